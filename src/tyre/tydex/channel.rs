//! Channels that are read: the format's names, with the axes in the last letter.
//!
//! | axes | origin | y | z |
//! |---|---|---|---|
//! | C | wheel centre | the spin axis | in the wheel plane |
//! | H | wheel centre | along the road | upright on the road |
//! | W | contact | along the road | upright on the road |
//!
//! x lies in the wheel plane and along the road in all of them.

use super::unit::Quantity;

/// Where a force or moment is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Axes {
    /// Carrier: leans with the wheel.
    C,
    /// Horizontal: at the wheel centre, upright.
    H,
    /// Wheel: in the contact, upright.
    W,
}

/// Meaning of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// `LONGSLIP`.
    SlipRatio,
    /// `SLIPANGL`.
    SlipAngle,
    /// `INCLANGL`.
    Camber,
    /// `DSTGRWHC`: distance of the wheel centre from the road in the wheel plane.
    LoadedRadius,
    /// `FX`: the same in all axes.
    ForceX,
    /// `FY`.
    ForceY(Axes),
    /// `FZ`.
    ForceZ(Axes),
    /// `MX`.
    MomentX(Axes),
    /// `MZ`.
    MomentZ(Axes),
}

impl Meaning {
    /// Of a channel's or constant's name; none of the many that no tyre model is compared by.
    pub(crate) fn of(name: &str) -> Option<Self> {
        let name = name.to_ascii_uppercase();
        Some(match name.as_str() {
            "LONGSLIP" => Meaning::SlipRatio,
            "SLIPANGL" => Meaning::SlipAngle,
            "INCLANGL" => Meaning::Camber,
            "DSTGRWHC" => Meaning::LoadedRadius,
            "FX" | "FXC" | "FXH" | "FXW" => Meaning::ForceX,
            _ => {
                let axes = match name.get(2..) {
                    Some("C") => Axes::C,
                    Some("H") => Axes::H,
                    Some("W") => Axes::W,
                    _ => return None,
                };
                match name.get(..2) {
                    Some("FY") => Meaning::ForceY(axes),
                    Some("FZ") => Meaning::ForceZ(axes),
                    Some("MX") => Meaning::MomentX(axes),
                    Some("MZ") => Meaning::MomentZ(axes),
                    _ => return None,
                }
            }
        })
    }

    /// Quantity of the channel.
    pub(crate) fn quantity(self) -> Quantity {
        match self {
            Meaning::SlipRatio => Quantity::Ratio,
            Meaning::SlipAngle | Meaning::Camber => Quantity::Angle,
            Meaning::LoadedRadius => Quantity::Length,
            Meaning::ForceX | Meaning::ForceY(_) | Meaning::ForceZ(_) => Quantity::Force,
            Meaning::MomentX(_) | Meaning::MomentZ(_) => Quantity::Moment,
        }
    }
}
