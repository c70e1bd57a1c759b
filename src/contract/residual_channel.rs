//! Channels of the residuals on the road: equations of the nominal model that vanish when it is right
//! (`discrepancies`, column `channel`). Their formulas are in `diagnose::residuals`.

use std::ops::{Index, IndexMut};

use super::channel::Channel;

macro_rules! channels {
    ($($(#[$doc:meta])* $variant:ident: $name:literal, $unit:literal, $words:literal, $signals:expr;)*) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum ResidualChannel {
            $($(#[$doc])* $variant,)*
        }

        impl ResidualChannel {
            /// All of them, in their order.
            pub const ALL: [ResidualChannel; [$($name),*].len()] = [$(ResidualChannel::$variant),*];

            /// Their names, in their order.
            pub const NAMES: [&str; Self::ALL.len()] = [$($name),*];
            /// Their units, in their order.
            pub const UNITS: [&str; Self::ALL.len()] = [$($unit),*];

            /// As in the tables.
            pub fn name(self) -> &'static str {
                match self {
                    $(ResidualChannel::$variant => $name,)*
                }
            }

            /// Its unit; slips are in standard deviations.
            pub fn unit(self) -> &'static str {
                match self {
                    $(ResidualChannel::$variant => $unit,)*
                }
            }

            pub fn words(self) -> &'static str {
                match self {
                    $(ResidualChannel::$variant => $words,)*
                }
            }

            /// Signals in which a misfit shows, the nearest first.
            pub fn signals(self) -> &'static [Channel] {
                match self {
                    $(ResidualChannel::$variant => &$signals,)*
                }
            }
        }
    };
}

channels! {
    /// Longitudinal acceleration less that of the forces.
    ForceX: "force_x", "m/s2", "force along the bike",
        [Channel::AccelerationX, Channel::VelocityX];
    /// Front friction less that of the slip, in standard deviations.
    SlipFront: "slip_front", "1", "front slip for its force",
        [Channel::WheelSpeedFront, Channel::VelocityX];
    /// The same at the rear.
    SlipRear: "slip_rear", "1", "rear slip for its force",
        [Channel::WheelSpeedRear, Channel::VelocityX];
    /// Front slip angle less that of the side force.
    LateralFront: "lateral_front", "rad", "front slip angle for its force",
        [Channel::SteerAngle, Channel::YawRate, Channel::VelocityY];
    /// The same at the rear.
    LateralRear: "lateral_rear", "rad", "rear slip angle for its force",
        [Channel::VelocityY, Channel::YawRate];
    /// Lateral acceleration less that of the roll balance.
    Roll: "roll", "m/s2", "roll balance",
        [Channel::Roll, Channel::AccelerationY];
    /// Rate of the forward velocity less the acceleration.
    KinematicX: "kinematic_x", "m/s2", "speed against forward acceleration",
        [Channel::VelocityX, Channel::AccelerationX];
    /// Lateral acceleration less that of the lateral velocity.
    KinematicY: "kinematic_y", "m/s2", "sideways speed against acceleration",
        [Channel::VelocityY, Channel::AccelerationY];
}

impl ResidualChannel {
    /// Lateral channels, front and rear.
    pub const LATERAL: [ResidualChannel; 2] =
        [ResidualChannel::LateralFront, ResidualChannel::LateralRear];

    /// The channel of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.name() == name)
    }
}

/// Number of channels.
const COUNT: usize = ResidualChannel::ALL.len();

/// A value per channel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PerChannel<T>([T; COUNT]);

impl<T> PerChannel<T> {
    /// Of a function of the channel.
    pub fn from_fn(mut f: impl FnMut(ResidualChannel) -> T) -> Self {
        PerChannel(std::array::from_fn(|c| f(ResidualChannel::ALL[c])))
    }

    /// The values in the channels' order.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.0.iter()
    }

    /// The values in the channels' order, to be changed.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
        self.0.iter_mut()
    }
}

impl<T> Index<ResidualChannel> for PerChannel<T> {
    type Output = T;

    #[inline]
    fn index(&self, channel: ResidualChannel) -> &T {
        &self.0[channel as usize]
    }
}

impl<T> IndexMut<ResidualChannel> for PerChannel<T> {
    #[inline]
    fn index_mut(&mut self, channel: ResidualChannel) -> &mut T {
        &mut self.0[channel as usize]
    }
}

impl<T> IntoIterator for PerChannel<T> {
    type Item = T;
    type IntoIter = std::array::IntoIter<T, COUNT>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a, T> IntoIterator for &'a PerChannel<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<'a, T> IntoIterator for &'a mut PerChannel<T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter_mut()
    }
}
