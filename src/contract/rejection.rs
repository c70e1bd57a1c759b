//! Why a log is not used: the stage that refuses it, and a code for programs.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A fieldless enum whose variants have a text in the tables and a sentence in the book.
macro_rules! texts {
    ($(#[$doc:meta])* $name:ident { $($variant:ident: $text:literal, $words:literal;)+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub enum $name {
            $(#[doc = $words] #[serde(rename = $text)] $variant,)+
        }

        impl $name {
            /// All of them, in the order of the book's list.
            pub const ALL: &'static [$name] = &[$($name::$variant),+];

            /// Text in the tables.
            pub const fn as_str(self) -> &'static str {
                match self { $($name::$variant => $text,)+ }
            }

            /// Meaning, a sentence.
            pub const fn words(self) -> &'static str {
                match self { $($name::$variant => $words,)+ }
            }

            /// Reads a table's text; `None` for a text that this version does not write.
            pub fn parse(text: &str) -> Option<Self> {
                $name::ALL.iter().copied().find(|x| x.as_str() == text)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.as_str())
            }
        }
    };
}

texts! {
    /// Where a log was refused.
    Stage {
        Discover: "discover", "The search for logs and their bike files.";
        Ingest: "ingest", "Reading, cleaning and checking the log.";
        Estimate: "estimate", "Angles, slips and forces along the ride.";
        Pipeline: "pipeline", "A worker that ended without a result.";
        Diagnose: "diagnose", "The diagnosis.";
        Write: "write", "Writing the tables.";
    }
}

texts! {
    /// Kind of a rejection. Messages may change, codes stay.
    RejectionCode {
        NotFound: "not_found", "There is no such file.";
        NoLogs: "no_logs", "There is a folder, and no log in it.";
        Unreadable: "unreadable", "This machine cannot read the log: no permission, or a failing disk.";
        Unreachable: "unreachable", "The object store did not deliver the log.";
        Changed: "changed", "The log changed while it was read.";
        DuplicateLog: "duplicate_log", "Another log has the same bytes.";
        DuplicateSessionId: "duplicate_session_id", "Another log has the same session id.";
        NoBikeId: "no_bike_id", "The log does not say on which bike it was ridden.";
        BadBikeId: "bad_bike_id", "The bike's id cannot name a file.";
        BadSessionId: "bad_session_id", "The session's id cannot name a file.";
        NoBikeFile: "no_bike_file", "The bike has no file.";
        BadBikeFile: "bad_bike_file", "The bike file cannot be used.";
        Damaged: "damaged", "The log is damaged.";
        Truncated: "truncated", "The log is cut off.";
        CutOff: "cut_off", "The log ends within its header.";
        EmptyFile: "empty_file", "The log has no bytes.";
        FileTooLarge: "file_too_large", "The log would unpack to more than can be read.";
        UnknownFormat: "unknown_format", "The log's format is unknown.";
        UnknownVersion: "unknown_version", "roadbench does not read this version of the log's format.";
        UnknownCompression: "unknown_compression", "roadbench does not read the log's compression.";
        NotParquet: "not_parquet", "The log has the ending of a Parquet file but is not one.";
        NoTable: "no_table", "The text has no table of numbers.";
        CellCount: "cell_count", "Too many lines have another number of cells than the header.";
        BadCell: "bad_cell", "Too many cells are no numbers.";
        BadDbc: "bad_dbc", "The CAN database cannot be read.";
        NoChannelMap: "no_channel_map", "No channel map fits the log.";
        NoChannels: "no_channels", "The log has no channels.";
        NoSamples: "no_samples", "The log has no samples.";
        NoTime: "no_time", "The log has no time that can be used.";
        MissingColumn: "missing_column", "A column that is needed is missing.";
        AmbiguousColumn: "ambiguous_column", "Several columns have the name.";
        WrongType: "wrong_type", "A column's type is not that of numbers.";
        UnknownUnit: "unknown_unit", "A unit is not known, or does not fit the channel.";
        UnitMismatch: "unit_mismatch", "The channel map and the log give different units.";
        MixedClocks: "mixed_clocks", "A channel is the mean of columns with different clocks.";
        CoordinateSystem: "coordinate_system", "The log's axes are not those that its numbers need.";
        ImplausibleClock: "implausible_clock", "The clock contradicts itself or the motion.";
        TooShort: "too_short", "The log has too little usable time.";
        TooFewManoeuvres: "too_few_manoeuvres", "The ride has too little to diagnose.";
        Standstill: "standstill", "There is too little motion to check anything.";
        SignVelocityX: "sign_velocity_x", "The velocity is negative while riding.";
        UnitVelocity: "unit_velocity", "The velocity is in another unit than m/s.";
        SpeedOverGround: "speed_over_ground", "Velocity and track over ground disagree.";
        UnitWheelSpeed: "unit_wheel_speed", "A wheel speed is in another unit than rad/s.";
        SignWheelSpeed: "sign_wheel_speed", "A wheel speed is negative while riding.";
        ImplausibleRadius: "implausible_radius", "Velocity over wheel speed is not the radius of a wheel.";
        Stuck: "stuck", "A channel is constant while the others move.";
        Impossible: "impossible", "Many samples are beyond what a motorcycle does.";
        UnitAngle: "unit_angle", "An angle is in degrees.";
        UnitRate: "unit_rate", "An angular rate or its angle is in degrees.";
        SignRollYaw: "sign_roll_yaw", "Roll and yaw rate turn opposite ways.";
        SignYaw: "sign_yaw", "Yaw and yaw rate turn opposite ways.";
        SignRollRate: "sign_roll_rate", "Roll rate and roll turn opposite ways.";
        SignSteer: "sign_steer", "Steering and path turn opposite ways.";
        SignLateral: "sign_lateral", "Roll, yaw rate and the track over ground contradict each other.";
        SignAccelerationX: "sign_acceleration_x", "The longitudinal acceleration has the wrong sign.";
        SignAccelerationY: "sign_acceleration_y", "The lateral acceleration has the wrong sign.";
        UnitAcceleration: "unit_acceleration", "An acceleration is in g.";
        GravityInAcceleration: "gravity_in_acceleration", "An acceleration has gravity in it.";
        SignVelocityY: "sign_velocity_y", "The lateral velocity has the wrong sign.";
        ScaleVelocityY: "scale_velocity_y", "The lateral velocity is too large for the lateral acceleration.";
        ScaleAcceleration: "scale_acceleration", "The longitudinal acceleration disagrees with the speed.";
        CalculatedLean: "calculated_lean", "The lean is calculated from the lateral acceleration.";
        ScaleLateral: "scale_lateral", "A channel disagrees with the others in corners.";
        ScaleRate: "scale_rate", "An angular rate disagrees with its angle.";
        ScaleSteer: "scale_steer", "Steering disagrees with the path.";
        UnitPressure: "unit_pressure", "A brake pressure is in another unit than Pa.";
        SignPressure: "sign_pressure", "A brake pressure falls when it brakes.";
        SignThrottle: "sign_throttle", "The throttle is open under braking.";
        WheelsSwapped: "wheels_swapped", "Front and rear wheel speed are swapped.";
        BrakesSwapped: "brakes_swapped", "Front and rear brake are swapped.";
        BrakesUnclear: "brakes_unclear", "The brakes brake harder than a rear brake can, by either channel.";
        Crashed: "crashed", "The worker crashed while it read the log.";
        TooLarge: "too_large", "Reading the log takes more memory than the limit.";
        TooSlow: "too_slow", "Reading the log takes more processor time than the limit.";
        Killed: "killed", "The worker was killed from outside.";
        NoWorker: "no_worker", "No worker process could be started.";
        NoMemory: "no_memory", "The worker had less memory than its limit.";
        InternalError: "internal_error", "A mistake in roadbench.";
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::store::tables::registry;

    /// In TOML and JSON an enum's text is the table's.
    #[test]
    fn texts_are_unique_and_read_back() {
        let texts: BTreeSet<&str> = RejectionCode::ALL.iter().map(|c| c.as_str()).collect();
        assert_eq!(texts.len(), RejectionCode::ALL.len());
        for code in RejectionCode::ALL {
            assert_eq!(RejectionCode::parse(code.as_str()), Some(*code));
            let json = serde_json::to_string(code).expect("json");
            assert_eq!(json, format!("\"{code}\""));
        }
        assert!(Stage::ALL.iter().all(|s| Stage::parse(s.as_str()) == Some(*s)));
        assert_eq!(RejectionCode::parse("of another version"), None);
    }

    /// The schema lists the stages.
    #[test]
    fn stages_are_documented() {
        let table = registry::ALL.iter().map(|spec| spec.table()).find(|t| t.name == "rejected");
        let column = table.and_then(|t| t.column("stage")).expect("a column");
        let listed = column.description.split_once(": ").expect("a list").1.trim_end_matches('.');
        let listed: Vec<&str> = listed.split(", ").flat_map(|s| s.split(" or ")).collect();
        let stages: Vec<&str> = Stage::ALL.iter().map(|s| s.as_str()).collect();
        assert_eq!(listed, stages);
    }
}
