//! What people call the columns of `session.v1`.

use super::languages::english;
use crate::contract::channel::Channel;
use crate::ingest::clock::stamps::names::folded;

use Channel::*;

/// How a column is recognised.
pub(super) struct Rule {
    pub channel: Channel,
    /// Quantity of its unit.
    pub dimension: &'static str,
    /// Sets of words; all of one of them must be in the name. The one of most words counts.
    sets: &'static [&'static str],
    /// Words that must not be in the name.
    not: &'static str,
    /// Hint for the owner of the log.
    pub hint: Option<&'static str>,
}

const fn rule(
    channel: Channel,
    dimension: &'static str,
    sets: &'static [&'static str],
    not: &'static str,
) -> Rule {
    Rule { channel, dimension, sets, not, hint: None }
}

impl Rule {
    const fn hint(self, hint: &'static str) -> Rule {
        Rule { hint: Some(hint), ..self }
    }

    /// How many words of the name are its own; `None` if it is not meant.
    pub(super) fn score(&self, words: &[String]) -> Option<usize> {
        if self.not.split(' ').any(|n| has(words, n))
            || TRAPS.iter().any(|n| words.iter().any(|w| w == n))
        {
            return None;
        }
        let fits = |set: &&&str| set.split(' ').all(|word| has(words, word));
        self.sets.iter().filter(fits).map(|set| 1 + set.split(' ').count()).max()
    }

    /// Whether the rider moves it: in a log of riding it changes.
    pub(super) fn is_controlled(&self) -> bool {
        matches!(self.channel, Throttle | BrakePressureFront | BrakePressureRear)
    }

    /// Whether a throttle is that of the rider's hand.
    pub(super) fn is_grip(&self, words: &[String]) -> bool {
        const GRIP: [&str; 6] = ["grip", "aps", "apps", "accelerator", "pedal", "twist"];
        self.channel == Throttle && words.iter().any(|w| GRIP.contains(&w.as_str()))
    }

    /// Whether it is a wheel's spin.
    pub(super) fn is_wheel(&self) -> bool {
        matches!(self.channel, WheelSpeedFront | WheelSpeedRear)
    }
}

/// Words of what is no measurement of a column's quantity: flags, wishes, raw voltages, corrections.
const TRAPS: [&str; 48] = [
    "error",
    "err",
    "fault",
    "flag",
    "flags",
    "status",
    "state",
    "valid",
    "target",
    "tgt",
    "setpoint",
    "desired",
    "demand",
    "request",
    "req",
    "raw",
    "volt",
    "volts",
    "voltage",
    "adc",
    "counts",
    "offset",
    "limit",
    "enable",
    "warning",
    "mode",
    "correction",
    "corr",
    "max",
    "min",
    "switch",
    "lamp",
    "light",
    "heater",
    "average",
    "avg",
    "mean",
    "diff",
    "difference",
    "vs",
    "delta",
    "commanded",
    "command",
    "cmd",
    "quality",
    "diag",
    "pseudo",
    "predicted",
];

const LEVEL: &str = "in the level frame, without gravity; of a unit that leans map all six as imu_force_x|y|z and imu_rate_x|y|z";
const EULER: &str = "the Euler angle's rate; of a unit that leans map all six as imu_force_x|y|z and imu_rate_x|y|z";

/// One for each column that loggers have, in schema order.
#[rustfmt::skip]
pub(super) const RULES: &[Rule] = &[
    rule(VelocityX, "speed", &["velocity x", "vel x", "vx", "v x", "gps speed", "gps velocity",
        "ground speed", "vehicle speed", "speed", "velocity", "v gps", "kph", "mph", "kmh", "km h"],
        "calc wheel whl front rear fl fr rl rr engine motor wind lateral vert vertical y z vy vz north east \
         down accuracy error max min angular limit drive gyro yaw roll pitch susp damper fork shock distance trip"),
    rule(VelocityY, "speed", &["velocity y", "vel y", "vy", "v y", "lateral velocity", "lateral speed"],
        "angular wind accuracy"),
    rule(AccelerationX, "acceleration", &["acceleration x", "accel x", "acc x", "ax", "longitudinal acceleration",
        "long acc", "long accel", "lon acc", "lonacc", "longacc", "g force x", "inline acc", "lon g", "g long", "g force long", "acc long"],
        "angular fork shock chassis head tail front rear sensor").hint(LEVEL),
    rule(AccelerationY, "acceleration", &["acceleration y", "accel y", "acc y", "ay", "lateral acceleration",
        "lat acc", "lat accel", "latacc", "lateral accel", "g force y", "lateral acc", "lat g", "g lat", "g force lat", "acc lat"],
        "angular fork shock chassis head tail front rear sensor").hint(LEVEL),
    rule(Roll, "angle", &["roll", "roll angle", "lean", "lean angle", "bank angle", "banking", "bike angle"], "rate rollrate gyro acc velocity vel"),
    rule(Pitch, "angle", &["pitch", "pitch angle"], "rate pitchrate gyro acc velocity vel"),
    rule(Yaw, "angle", &["yaw", "yaw angle", "heading", "course", "bearing"], "rate yawrate gyro acc velocity vel accuracy")
        .hint("positive to the left: a compass course needs `sign = -1`"),
    rule(RollRate, "angular rate", &["roll rate", "roll velocity", "gyro x", "gyr x", "angular velocity x",
        "rate x", "lean rate", "rollrate", "roll deg s"], "acc").hint(EULER),
    rule(PitchRate, "angular rate", &["pitch rate", "pitch velocity", "gyro y", "gyr y", "angular velocity y",
        "rate y", "pitchrate", "pitch deg s"], "acc").hint(EULER),
    rule(YawRate, "angular rate", &["yaw rate", "yaw velocity", "gyro z", "gyr z", "angular velocity z", "rate z", "yawrate", "gps gyro", "yaw deg s"],
        "acc").hint(EULER),
    rule(SteerAngle, "angle", &["steer", "steering", "steer angle", "steering angle", "handlebar"], "rate torque velocity"),
    rule(WheelSpeedFront, "angular rate", &["wheel speed front", "wheel front", "wheel speed f", "speed front",
        "whl f", "speed f", "wheel f", "wspd f", "wspd front", "v front", "vfront", "wheel fr", "speed fr", "wheel spd front"], "pressure temp brake susp fl fr torque acc"),
    rule(WheelSpeedRear, "angular rate", &["wheel speed rear", "wheel rear", "wheel speed r", "speed rear",
        "whl r", "speed r", "wheel r", "wspd r", "wspd rear", "v rear", "vrear", "wheel spd rear"], "pressure temp brake susp rl rr torque acc front fr"),
    rule(BrakePressureFront, "pressure", &["brake pressure front", "brake pressure f", "brake press front",
        "brake press f", "brake front", "brake f", "brake fr", "p brake front", "master cylinder front"], "temp rear tyre tire"),
    rule(BrakePressureRear, "pressure", &["brake pressure rear", "brake pressure r", "brake press rear",
        "brake press r", "brake rear", "brake r", "brake rr", "p brake rear", "master cylinder rear"], "temp front tyre tire"),
    rule(Throttle, "ratio", &["throttle", "throttle position", "tps", "aps", "grip", "accelerator", "accelerator pedal"], "rate target desired e rear front v fract fl rl"),
    rule(Gear, "ratio", &["gear", "gear position"], "ratio shift calc"),
    rule(LapNumber, "ratio", &["lap", "lap number", "lap no", "lap count", "lap counter"], "time distance best last beacon delta target marker"),
    rule(Latitude, "angle", &["latitude", "lat", "gps lat", "gps latitude"], "acc accel g accuracy std covariance"),
    rule(Longitude, "angle", &["longitude", "lon", "lng", "long", "gps lon", "gps long", "gps longitude"],
        "acc accel g accuracy std covariance"),
    rule(Altitude, "length", &["altitude", "alt", "gps altitude", "height"], "accuracy std covariance ride"),
    rule(AirTemperature, "temperature", &["air temperature", "air temp", "ambient temp", "ambient temperature", "ambient", "t air"],
        "intake inlet tyre tire"),
    rule(TyreTemperatureFront, "temperature", &["tyre temp front", "tire temp front", "tyre temp f", "tire temp f",
        "tyre temperature front", "tire temperature front", "t tyre front", "t tyre fr"], "rear"),
    rule(TyreTemperatureRear, "temperature", &["tyre temp rear", "tire temp rear", "tyre temp r", "tire temp r",
        "tyre temperature rear", "tire temperature rear", "t tyre rear", "t tyre rr"], "front"),
    rule(TyrePressureFront, "pressure", &["tyre pressure front", "tire pressure front", "tyre press front", "tire press front",
        "tyre pres front", "tire pres front", "tyre pressure f", "tire pressure f", "tpms front", "p tyre front", "p tyre fr", "p tyre f"], "rear brake"),
    rule(TyrePressureRear, "pressure", &["tyre pressure rear", "tire pressure rear", "tyre press rear", "tire press rear",
        "tyre pres rear", "tire pres rear", "tyre pressure r", "tire pressure r", "tpms rear", "p tyre rear", "p tyre rr", "p tyre r"], "front brake"),
    rule(SteerTorque, "torque", &["steer torque", "steering torque", "handlebar torque", "bar torque"], "engine brake wheel"),
    rule(BrakeTorqueFront, "torque", &["brake torque front", "brake torque f", "brake torque fr"], "rear engine"),
    rule(BrakeTorqueRear, "torque", &["brake torque rear", "brake torque r", "brake torque rr"], "front engine"),
    rule(SlipAngleFront, "angle", &["slip angle front", "slip angle f", "slip angle fr"], "rear ratio"),
    rule(SlipAngleRear, "angle", &["slip angle rear", "slip angle r", "slip angle rr"], "front ratio"),
    rule(WheelForceXFront, "force", &["wheel force x front", "fx front", "fx f", "front fx"], "rear"),
    rule(WheelForceXRear, "force", &["wheel force x rear", "fx rear", "fx r", "rear fx"], "front"),
    rule(WheelForceYFront, "force", &["wheel force y front", "fy front", "fy f", "front fy"], "rear"),
    rule(WheelForceYRear, "force", &["wheel force y rear", "fy rear", "fy r", "rear fy"], "front"),
    rule(WheelForceZFront, "force", &["wheel force z front", "fz front", "fz f", "front fz"], "rear"),
    rule(WheelForceZRear, "force", &["wheel force z rear", "fz rear", "fz r", "rear fz"], "front"),
    rule(WheelMomentXFront, "torque", &["wheel moment x front", "mx front", "mx f", "front mx"], "rear"),
    rule(WheelMomentXRear, "torque", &["wheel moment x rear", "mx rear", "mx r", "rear mx"], "front"),
    rule(ForkTravel, "length", &["fork", "fork travel", "fork position", "suspension front", "susp front", "susp f", "susp fr",
        "damper front", "front travel"], "acc accel velocity rear"),
    rule(ShockTravel, "length", &["shock", "shock travel", "shock position", "suspension rear", "susp rear", "susp r", "susp rr",
        "damper rear", "rear travel"], "acc accel velocity front"),
];

/// The words of a name, in lower case and in English where they are of another known language: `WheelSpeed_Front2` is
/// `wheel`, `speed`, `front`, `2`, and `Schräglage` is `lean`.
pub(super) fn words(name: &str) -> Vec<String> {
    let own = own_words(name);
    let mut words = Vec::with_capacity(own.len());
    for (i, word) in own.iter().enumerate() {
        match english(&folded(word)) {
            Some(english) => words.extend(english.split(' ').map(str::to_owned)),
            None if is_german_wheel(word, own.get(i + 1)) => words.push("wheel".to_owned()),
            None => words.push(word.clone()),
        }
    }
    words
}

/// `Rad vorne` is a wheel; elsewhere the word is a unit of angles.
fn is_german_wheel(word: &str, next: Option<&String>) -> bool {
    word == "rad" && next.is_some_and(|next| matches!(next.as_str(), "vorn" | "vorne" | "hinten"))
}

/// The words of a name as they stand there, in lower case.
fn own_words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words = vec![String::new()];
    for (i, &c) in letters.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| letters[i]);
        let after = letters.get(i + 1);
        let starts = before.is_some_and(|b| {
            (c.is_uppercase() && b.is_lowercase())
                || (c.is_ascii_digit() != b.is_ascii_digit())
                // the last capital of `GPSSpeed` begins a word
                || (c.is_uppercase() && b.is_uppercase() && after.is_some_and(|a| a.is_lowercase()))
        });
        if starts || !c.is_alphanumeric() {
            words.push(String::new());
        }
        if c.is_alphanumeric()
            && let Some(word) = words.last_mut()
        {
            word.extend(c.to_lowercase());
        }
    }
    words.retain(|w| !w.is_empty());
    words
}

/// Whether a word is among a name's: as it is, and longer ones as the beginning of another or
/// anywhere in a name that is written in one.
fn has(words: &[String], word: &str) -> bool {
    words.iter().any(|w| {
        w == word
            || (word.len() >= 4 && w.starts_with(word))
            || (word.len() >= 5 && w.contains(word))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fall_into_words() {
        assert_eq!(words("WheelSpeed_Front2"), ["wheel", "speed", "front", "2"]);
        assert_eq!(words("GPSSpeed (km/h)"), ["gps", "speed", "km", "h"]);
        assert_eq!(words("angular_velocity.z"), ["angular", "velocity", "z"]);
        assert!(words("__").is_empty());
        assert_eq!(words("Rad vorne"), ["wheel", "front"]);
        assert_eq!(words("lean rad"), ["lean", "rad"]);
    }

    #[test]
    fn names_of_real_loggers_are_recognised() {
        let of = |name: &str| {
            let words = words(name);
            let best = RULES.iter().filter_map(|r| Some((r.score(&words)?, r.channel)));
            best.max_by_key(|(score, _)| *score).map(|(_, c)| c)
        };
        for (name, channel) in [
            ("GPS Speed", VelocityX),
            ("wheelspeedfront", WheelSpeedFront),
            ("Brake Pressure Rear", BrakePressureRear),
            ("angular_velocity.z", YawRate),
            ("linear_acceleration.x", AccelerationX),
            ("G Force Lat", AccelerationY),
            ("Throttle Pos", Throttle),
            ("latitude", Latitude),
            ("Lean", Roll),
            ("v_front", WheelSpeedFront),
            ("v_rear", WheelSpeedRear),
            ("p_brake_fr", BrakePressureFront),
            ("p_brake_rr", BrakePressureRear),
            ("s_susp_fr", ForkTravel),
            ("s_susp_rr", ShockTravel),
            ("yawrate_imu", YawRate),
            ("rollrate_imu", RollRate),
            ("GPS LonAcc", AccelerationX),
            ("GPS LatAcc", AccelerationY),
            ("GPS Gyro", YawRate),
            ("TPS", Throttle),
            ("Brake F", BrakePressureFront),
            ("Brake R", BrakePressureRear),
            ("Wheel Speed F", WheelSpeedFront),
            ("Wheel Speed R", WheelSpeedRear),
            ("Wheel_Speed_Rear", WheelSpeedRear),
            ("Course", Yaw),
            ("Gear", Gear),
            ("GPS_Speed", VelocityX),
            ("Vehicle Speed", VelocityX),
            ("speed_gps", VelocityX),
            ("InlineAcc", AccelerationX),
            ("LateralAcc", AccelerationY),
            ("longitudinal_acc", AccelerationX),
            ("lateral_acc", AccelerationY),
            ("G Force Long", AccelerationX),
            ("LonG", AccelerationX),
            ("LatG", AccelerationY),
            ("Accel X", AccelerationX),
            ("acc_x", AccelerationX),
            ("Lean Angle", Roll),
            ("lean_angle", Roll),
            ("LeanAngle", Roll),
            ("Bank Angle", Roll),
            ("Heading", Yaw),
            ("bearing", Yaw),
            ("GPS Heading", Yaw),
            ("GyroZ", YawRate),
            ("Gyro Z", YawRate),
            ("Yaw Rate", YawRate),
            ("YawRate", YawRate),
            ("z_rate_of_rotation", YawRate),
            ("RollRate", RollRate),
            ("Pitch Rate", PitchRate),
            ("pitchrate_imu", PitchRate),
            ("Steering Angle", SteerAngle),
            ("front_speed", WheelSpeedFront),
            ("front_speed_kmh", WheelSpeedFront),
            ("rear_speed_kmh", WheelSpeedRear),
            ("FWheelSpeed", WheelSpeedFront),
            ("RWheelSpeed", WheelSpeedRear),
            ("Front Wheel Speed", WheelSpeedFront),
            ("Rad vorne", WheelSpeedFront),
            ("Rad hinten", WheelSpeedRear),
            ("wspd_f", WheelSpeedFront),
            ("wspd_r", WheelSpeedRear),
            ("SPEED FRONT", WheelSpeedFront),
            ("SPEED REAR", WheelSpeedRear),
            ("BrakePressF", BrakePressureFront),
            ("BrakePressR", BrakePressureRear),
            ("front_brake_bar", BrakePressureFront),
            ("Front Brake Pressure", BrakePressureFront),
            ("PBrakeF", BrakePressureFront),
            ("Brake Press Rear", BrakePressureRear),
            ("THROTTLE", Throttle),
            ("throttle_pos", Throttle),
            ("Throttle Position", Throttle),
            ("TPS1", Throttle),
            ("APS", Throttle),
            ("GearPos", Gear),
            ("Lap Number", LapNumber),
            ("GPS Latitude", Latitude),
            ("Longitude", Longitude),
            ("GPS Altitude", Altitude),
            ("Ambient Temp", AirTemperature),
            ("Fork Position", ForkTravel),
            ("Shock Position", ShockTravel),
            ("Susp Front", ForkTravel),
            ("SUSP_R", ShockTravel),
            ("Tyre Temp F", TyreTemperatureFront),
            ("TireTempRear", TyreTemperatureRear),
            ("Tyre Pressure F", TyrePressureFront),
            ("Front Tyre Pressure", TyrePressureFront),
            ("Steering Torque", SteerTorque),
            ("Slip Angle Rear", SlipAngleRear),
            ("Fz_front", WheelForceZFront),
        ] {
            assert_eq!(of(name), Some(channel), "{name}");
        }
        for name in [
            "Engine RPM",
            "Coolant Temp",
            "Battery",
            "wind speed",
            "wspd",
            "E_grip",
            "Throttle Target",
            "TPS raw",
            "TPS volt",
            "Lean Angle Offset",
            "Gear Error",
            "Brake Pressure F Status",
            "Speed Limit",
            "Pit Speed Mode",
            "Wheel Speed Front Valid",
            "rpm",
            "TPS_V",
            "Brake Press F ADC",
            "gear_target",
            "GearVoltage",
            "Speed Accuracy",
            "heading_accuracy",
            "Lean Status",
            "Lambda Setpoint",
            "Brake Temp Front",
            "Brake Disc Temp F",
            "Brake Lamp",
            "Brake Light Front",
            "front_brake_switch",
            "GPS Satellites",
            "Lap Time",
            "Best Lap",
            "Clutch",
            "Slip Target",
            "wheelie_flag",
            "Launch Control Mode",
            "TC_level",
            "Lap Distance",
            "Speed Correction Front",
            "Wheel Speed Ratio",
            "Oil Pressure",
            "Fuel Pressure",
            "Gear Shift",
            "Battery Voltage",
            "max_lean",
            "Lean Max",
            "Roll Correction",
            "Grip Heater",
            "Throttle Max",
        ] {
            assert_eq!(of(name), None, "{name}");
        }
    }
}
