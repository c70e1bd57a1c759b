//! Why a log is not used: where that was found, and a code for programs. Sentences may change, codes stay.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Where it was found that a log cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Before the log was opened.
    Discover,
    /// While it was read, cleaned or checked.
    Ingest,
    /// Anywhere in `run`.
    Pipeline,
    /// While forces were estimated.
    Estimate,
    /// In `diagnose`.
    Diagnose,
    /// While tables were made.
    Write,
}

impl Stage {
    const ALL: [Stage; 6] = [
        Stage::Discover,
        Stage::Ingest,
        Stage::Pipeline,
        Stage::Estimate,
        Stage::Diagnose,
        Stage::Write,
    ];

    /// In the tables.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Discover => "discover",
            Stage::Ingest => "ingest",
            Stage::Pipeline => "pipeline",
            Stage::Estimate => "estimate",
            Stage::Diagnose => "diagnose",
            Stage::Write => "write",
        }
    }

    /// The stage of a name in the tables.
    pub(crate) fn from_name(name: &str) -> Option<Stage> {
        Stage::ALL.into_iter().find(|stage| stage.name() == name)
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

macro_rules! codes {
    ($($variant:ident: $name:literal, $words:literal;)+) => {
        /// Why a log is not used.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum RejectionCode {
            $(#[doc = $words] $variant,)+
        }

        impl RejectionCode {
            const ALL: &'static [RejectionCode] = &[$(RejectionCode::$variant),+];

            /// In the tables.
            pub fn name(self) -> &'static str {
                match self { $(RejectionCode::$variant => $name,)+ }
            }
        }
    };
}

codes! {
    Unreachable: "unreachable", "An object store did not give it; it may be in order.";
    Unreadable: "unreadable", "This machine could not read it; it may be in order.";
    Changed: "changed", "It was written anew while it was read.";
    Damaged: "damaged", "Its bytes make no sense.";
    NotFound: "not_found", "There is no such file.";
    NoLogs: "no_logs", "There is a folder, and no log in it.";
    DuplicateSessionId: "duplicate_session_id", "Another log of the batch has its session.";
    Killed: "killed", "Its worker was killed by somebody else.";
    NoWorker: "no_worker", "There was no worker for it.";
    NoMemory: "no_memory", "Its worker had less memory than it may have.";
    Crashed: "crashed", "Its worker crashed over it.";
    TooLarge: "too_large", "It takes more memory than it may.";
    TooSlow: "too_slow", "It takes more time than it may.";
    InternalError: "internal_error", "A mistake of the program.";
    AmbiguousColumn: "ambiguous_column", "A column name is there twice.";
    BadCell: "bad_cell", "A cell is no number.";
    BadDbc: "bad_dbc", "The CAN database cannot be read.";
    CellCount: "cell_count", "Rows have other numbers of cells than the header.";
    CoordinateSystem: "coordinate_system", "The coordinates are of an unknown system.";
    CutOff: "cut_off", "It is cut off.";
    EmptyFile: "empty_file", "It is empty.";
    FileTooLarge: "file_too_large", "It is larger than can be read.";
    ImplausibleClock: "implausible_clock", "Its clock cannot be right.";
    MissingColumn: "missing_column", "A column that every session needs is missing.";
    NoChannelMap: "no_channel_map", "No channel map fits it.";
    NoChannels: "no_channels", "It has no channel that is known.";
    NoSamples: "no_samples", "It has no samples.";
    NoTable: "no_table", "It has no table.";
    NoTime: "no_time", "It has no usable time.";
    NotParquet: "not_parquet", "It is no Parquet file.";
    TooShort: "too_short", "It is too short.";
    Truncated: "truncated", "It ends too early.";
    UnitMismatch: "unit_mismatch", "A unit contradicts the channel.";
    UnknownCompression: "unknown_compression", "Its compression is unknown.";
    UnknownFormat: "unknown_format", "Its format is unknown.";
    UnknownUnit: "unknown_unit", "A unit is unknown.";
    UnknownVersion: "unknown_version", "Its version is unknown.";
    WrongType: "wrong_type", "A column has another type than it should.";
    MixedClocks: "mixed_clocks", "Its channels are on clocks that cannot be brought together.";
    NoBikeId: "no_bike_id", "Nothing says whose motorcycle it is.";
    NoBikeFile: "no_bike_file", "There is no bike file for its motorcycle.";
    DuplicateLog: "duplicate_log", "Another log of the batch has the same bytes.";
    BadBikeId: "bad_bike_id", "The name of its motorcycle cannot be a file name.";
    BadSessionId: "bad_session_id", "The name of its session cannot be a file name.";
    BadBikeFile: "bad_bike_file", "The bike file cannot be used for it.";
    TooFewManoeuvres: "too_few_manoeuvres", "It has too few manoeuvres.";
    Standstill: "standstill", "The check of that name.";
    SignVelocityX: "sign_velocity_x", "The check of that name.";
    UnitVelocity: "unit_velocity", "The check of that name.";
    SpeedOverGround: "speed_over_ground", "The check of that name.";
    UnitWheelSpeed: "unit_wheel_speed", "The check of that name.";
    SignWheelSpeed: "sign_wheel_speed", "The check of that name.";
    ImplausibleRadius: "implausible_radius", "The check of that name.";
    Stuck: "stuck", "The check of that name.";
    Impossible: "impossible", "The check of that name.";
    UnitAngle: "unit_angle", "The check of that name.";
    UnitRate: "unit_rate", "The check of that name.";
    SignRollYaw: "sign_roll_yaw", "The check of that name.";
    SignYaw: "sign_yaw", "The check of that name.";
    SignRollRate: "sign_roll_rate", "The check of that name.";
    SignSteer: "sign_steer", "The check of that name.";
    SignLateral: "sign_lateral", "The check of that name.";
    SignAccelerationX: "sign_acceleration_x", "The check of that name.";
    SignAccelerationY: "sign_acceleration_y", "The check of that name.";
    UnitAcceleration: "unit_acceleration", "The check of that name.";
    GravityInAcceleration: "gravity_in_acceleration", "The check of that name.";
    ScaleAcceleration: "scale_acceleration", "The check of that name.";
    ScaleLateral: "scale_lateral", "The check of that name.";
    ScaleRate: "scale_rate", "The check of that name.";
    ScaleSteer: "scale_steer", "The check of that name.";
    UnitPressure: "unit_pressure", "The check of that name.";
    SignPressure: "sign_pressure", "The check of that name.";
    SignThrottle: "sign_throttle", "The check of that name.";
    WheelsSwapped: "wheels_swapped", "The check of that name.";
    BrakesSwapped: "brakes_swapped", "The check of that name.";
    BrakesUnclear: "brakes_unclear", "The check of that name.";
}

impl RejectionCode {
    /// The code of a name in the tables.
    pub(crate) fn from_name(name: &str) -> Option<RejectionCode> {
        RejectionCode::ALL.iter().copied().find(|code| code.name() == name)
    }

    /// Whether the log itself is at fault: its bytes are bad, or end the worker that reads them. Then it has no session any
    /// more. Otherwise the next batch may well read it, and the rows that it had stay as they are.
    pub(crate) fn is_the_logs(self) -> bool {
        use RejectionCode::*;
        !matches!(
            self,
            Unreachable
                | Unreadable
                | Changed
                | NotFound
                | NoLogs
                | DuplicateSessionId
                | Killed
                | NoWorker
                | NoMemory
        )
    }

    /// Whether the log ended a worker, and would again.
    pub(crate) fn ends_a_worker(self) -> bool {
        use RejectionCode::*;
        matches!(self, Crashed | TooLarge | TooSlow)
    }
}

impl fmt::Display for RejectionCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl PartialEq<&str> for RejectionCode {
    fn eq(&self, name: &&str) -> bool {
        self.name() == *name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::checks::switches::CHECKS;

    #[test]
    fn names_are_those_of_serde_and_lead_back() {
        for code in RejectionCode::ALL {
            assert_eq!(RejectionCode::from_name(code.name()), Some(*code));
            assert_eq!(serde_json::to_value(code).expect("a text"), code.name());
        }
        for stage in Stage::ALL {
            assert_eq!(Stage::from_name(stage.name()), Some(stage));
            assert_eq!(serde_json::to_value(stage).expect("a text"), stage.name());
        }
    }

    #[test]
    fn every_check_may_refuse_a_log() {
        for check in CHECKS {
            assert!(RejectionCode::from_name(check.code).is_some(), "{}", check.code);
        }
    }

    #[test]
    fn what_ends_a_worker_is_the_logs_and_what_ends_it_from_outside_is_not() {
        use RejectionCode::*;
        assert!(
            [Crashed, TooLarge, TooSlow].into_iter().all(|c| c.is_the_logs() && c.ends_a_worker())
        );
        assert!([Damaged, TooShort, InternalError].into_iter().all(RejectionCode::is_the_logs));
        assert!([Killed, NoWorker, Unreadable, Changed].into_iter().all(|c| !c.is_the_logs()));
    }
}
