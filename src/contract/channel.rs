//! The channels of a riding session: one name per quantity, everywhere.
//!
//! Name, unit, meaning and physical range of each are declared once, in
//! `schemas/session.v1.toml`; this enum gives them to the code as constants, and a
//! test compares the two.

use std::fmt;

use super::key_error::KeyError;

macro_rules! channels {
    ($($variant:ident = $name:literal),* $(,)?) => {
        /// One measured quantity of a session (a column of `session.v1`), in SI units.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Channel {
            $(#[doc = concat!("`", $name, "`")] $variant),*
        }

        impl Channel {
            /// Every channel, in the order of the schema.
            pub const ALL: &'static [Channel] = &[$(Channel::$variant),*];
            /// Number of channels.
            pub const COUNT: usize = Self::ALL.len();

            /// The column's name in `session.v1`.
            pub fn name(self) -> &'static str {
                match self { $(Channel::$variant => $name),* }
            }

            /// The channel of that name, if there is one.
            pub fn from_name(name: &str) -> Option<Channel> {
                match name { $($name => Some(Channel::$variant),)* _ => None }
            }
        }
    };
}

channels! {
    VelocityX = "velocity_x",
    VelocityY = "velocity_y",
    AccelerationX = "acceleration_x",
    AccelerationY = "acceleration_y",
    Roll = "roll",
    Pitch = "pitch",
    Yaw = "yaw",
    RollRate = "roll_rate",
    PitchRate = "pitch_rate",
    YawRate = "yaw_rate",
    SteerAngle = "steer_angle",
    WheelSpeedFront = "wheel_speed_front",
    WheelSpeedRear = "wheel_speed_rear",
    BrakePressureFront = "brake_pressure_front",
    BrakePressureRear = "brake_pressure_rear",
    Throttle = "throttle",
    Gear = "gear",
    LapNumber = "lap_number",
    Latitude = "latitude",
    Longitude = "longitude",
    Altitude = "altitude",
    Grade = "grade",
    AirTemperature = "air_temperature",
    TyreTemperatureFront = "tyre_temperature_front",
    TyreTemperatureRear = "tyre_temperature_rear",
    TyrePressureFront = "tyre_pressure_front",
    TyrePressureRear = "tyre_pressure_rear",
    SteerTorque = "steer_torque",
    BrakeTorqueFront = "brake_torque_front",
    BrakeTorqueRear = "brake_torque_rear",
    SlipAngleFront = "slip_angle_front",
    SlipAngleRear = "slip_angle_rear",
    WheelForceXFront = "wheel_force_x_front",
    WheelForceXRear = "wheel_force_x_rear",
    WheelForceYFront = "wheel_force_y_front",
    WheelForceYRear = "wheel_force_y_rear",
    WheelForceZFront = "wheel_force_z_front",
    WheelForceZRear = "wheel_force_z_rear",
    WheelMomentXFront = "wheel_moment_x_front",
    WheelMomentXRear = "wheel_moment_x_rear",
    ChassisAccelerationZ = "chassis_acceleration_z",
    HeadAccelerationZ = "head_acceleration_z",
    TailAccelerationZ = "tail_acceleration_z",
    ForkTravel = "fork_travel",
    ShockTravel = "shock_travel",
    ForkTopAcceleration = "fork_top_acceleration",
    ForkBottomAcceleration = "fork_bottom_acceleration",
    ShockTopAcceleration = "shock_top_acceleration",
    ShockBottomAcceleration = "shock_bottom_acceleration",
    ImuRateX = "imu_rate_x",
    ImuRateY = "imu_rate_y",
    ImuRateZ = "imu_rate_z",
    ImuForceX = "imu_force_x",
    ImuForceY = "imu_force_y",
    ImuForceZ = "imu_force_z",
    SatelliteSpeed = "satellite_speed",
    Course = "course",
    Climb = "climb",
    VelocityXSd = "velocity_x_sd",
    VelocityYSd = "velocity_y_sd",
    AccelerationXSd = "acceleration_x_sd",
    AccelerationYSd = "acceleration_y_sd",
    RollSd = "roll_sd",
    PitchSd = "pitch_sd",
    YawSd = "yaw_sd",
    RollRateSd = "roll_rate_sd",
    PitchRateSd = "pitch_rate_sd",
    YawRateSd = "yaw_rate_sd",
}

impl Channel {
    /// The channel of that name.
    ///
    /// # Errors
    /// Error text with the nearest name.
    pub fn named(name: &str) -> Result<Self, KeyError> {
        Channel::from_name(name).ok_or_else(|| {
            let near =
                crate::contract::schema::closest(name, Channel::ALL.iter().map(|c| c.name()));
            let hint = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
            KeyError::UnknownChannel { name: name.to_owned(), hint }
        })
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
