//! Channel lists of real loggers and apps: which column each channel is drafted for.
//!
//! Names and units as their exports have them. `None` are traps: channels that are no measurement of any column, or of
//! which nobody can know it.

use super::*;
use Channel::*;

/// Group, name, unit, column.
type Named = (&'static str, &'static str, &'static str, Option<Channel>);

/// Share of the channels with a column that must be offered for it.
const RIGHT: f64 = 0.9;

/// Format and channels of each.
#[rustfmt::skip]
const LOGGERS: &[(&str, &str, &[Named])] = &[
    ("AiM Race Studio 3, bike without ECU", "aim_csv", &[
        ("", "GPS Speed", "km/h", Some(VelocityX)), ("", "GPS Nsat", "", None), ("", "GPS LatAcc", "g", Some(AccelerationY)),
        ("", "GPS LonAcc", "g", Some(AccelerationX)), ("", "GPS Slope", "deg", None), ("", "GPS Heading", "deg", Some(Yaw)),
        ("", "GPS Gyro", "deg/s", Some(YawRate)), ("", "GPS Altitude", "m", Some(Altitude)),
        ("", "GPS PosAccuracy", "mm", None), ("", "GPS SpdAccuracy", "km/h", None), ("", "GPS Radius", "m", None),
        ("", "GPS Latitude", "deg", Some(Latitude)), ("", "GPS Longitude", "deg", Some(Longitude)),
        ("", "Internal Battery", "V", None), ("", "External Voltage", "V", None), ("", "LoggerTemp", "°C", None),
        ("", "Luminosity", "%", None), ("", "Predictive Time", "s", None), ("", "Distance on GPS Speed", "m", None),
        ("", "Best Run Diff", "s", None), ("", "RPM", "rpm", None),
    ]),
    ("AiM with its own inertial sensors and an ECU", "aim_csv", &[
        ("", "InlineAcc", "g", Some(AccelerationX)), ("", "LateralAcc", "g", Some(AccelerationY)), ("", "VerticalAcc", "g", None),
        ("", "RollRate", "deg/s", Some(RollRate)), ("", "PitchRate", "deg/s", Some(PitchRate)),
        ("", "YawRate", "deg/s", Some(YawRate)), ("", "MagnetomX", "", None), ("", "ECU TPS", "%", Some(Throttle)),
        ("", "ECU GEAR", "gear", Some(Gear)), ("", "ECU FRONT BRAKE", "bar", Some(BrakePressureFront)),
        ("", "ECU REAR BRAKE", "bar", Some(BrakePressureRear)), ("", "Front Wheel Spd", "km/h", Some(WheelSpeedFront)),
        ("", "Rear Wheel Spd", "km/h", Some(WheelSpeedRear)), ("", "Bike Angle", "deg", Some(Roll)),
        ("", "Calculated Gear", "#", None), ("", "Front Tire Press", "bar", Some(TyrePressureFront)), ("", "Rear Tire Press", "bar", Some(TyrePressureRear)),
        ("", "ECU MAP", "mbar", None), ("", "Lambda", "lambda", None), ("", "Fuel Level", "l", None),
    ]),
    ("superbike, factory logger", "csv", &[
        ("", "v_front", "km/h", Some(WheelSpeedFront)), ("", "v_rear", "km/h", Some(WheelSpeedRear)),
        ("", "p_brake_fr", "bar", Some(BrakePressureFront)), ("", "p_brake_rr", "bar", Some(BrakePressureRear)),
        ("", "s_susp_fr", "mm", Some(ForkTravel)), ("", "s_susp_rr", "mm", Some(ShockTravel)),
        ("", "yawrate_imu", "°/s", Some(YawRate)), ("", "rollrate_imu", "°/s", Some(RollRate)),
        ("", "pitchrate_imu", "°/s", Some(PitchRate)), ("", "lean_imu", "°", Some(Roll)), ("", "ax_imu", "g", Some(AccelerationX)),
        ("", "ay_imu", "g", Some(AccelerationY)), ("", "E_grip", "", None), ("", "E_tps", "", None), ("", "target_throttle", "%", None),
        ("", "target_slip", "%", None), ("", "throttle", "%", Some(Throttle)), ("", "throttle_raw", "", None), ("", "throttle_V", "V", None),
        ("", "p_brake_fr_V", "V", None), ("", "p_tyre_fr", "bar", Some(TyrePressureFront)), ("", "p_tyre_rr", "bar", Some(TyrePressureRear)), ("", "T_tyre_fr", "°C", Some(TyreTemperatureFront)),
        ("", "T_tyre_rr", "°C", Some(TyreTemperatureRear)), ("", "gear", "", Some(Gear)), ("", "T_air_intake", "°C", None),
        ("", "v_susp_fr", "mm/s", None), ("", "lean_max", "°", None), ("", "slip_rear", "%", None),
    ]),
    ("MoTeC", "motec_ld", &[
        ("", "Ground Speed", "km/h", Some(VelocityX)), ("", "Drive Speed", "km/h", None), ("", "G Force Lat", "G", Some(AccelerationY)),
        ("", "G Force Long", "G", Some(AccelerationX)), ("", "G Force Vert", "G", None), ("", "Throttle Pos", "%", Some(Throttle)),
        ("", "Throttle Pos Sensor Voltage", "mV", None), ("", "Throttle Pos Error", "", None), ("", "Gear", "", Some(Gear)), ("", "Gear Voltage", "V", None),
        ("", "Brake Pressure Front", "kPa", Some(BrakePressureFront)), ("", "Brake Pressure Rear", "kPa", Some(BrakePressureRear)),
        ("", "Brake Pressure Front Offset", "kPa", None), ("", "Wheel Speed Front", "km/h", Some(WheelSpeedFront)),
        ("", "Wheel Speed Rear", "km/h", Some(WheelSpeedRear)), ("", "Lean Angle", "deg", Some(Roll)), ("", "Steered Angle", "deg", Some(SteerAngle)),
        ("", "Gyro Yaw Velocity", "deg/s", Some(YawRate)), ("", "Gyro Roll Velocity", "deg/s", Some(RollRate)),
        ("", "Gyro Pitch Velocity", "deg/s", Some(PitchRate)), ("", "Damper Pos Front", "mm", Some(ForkTravel)),
        ("", "Damper Pos Rear", "mm", Some(ShockTravel)), ("", "Damper Vel Front", "mm/s", None), ("", "GPS Heading", "deg", Some(Yaw)),
        ("", "Ambient Temp", "C", Some(AirTemperature)), ("", "Air Temp Inlet", "C", None), ("", "Tyre Temp Front", "C", Some(TyreTemperatureFront)),
        ("", "Tyre Pres Front", "kPa", Some(TyrePressureFront)), ("", "Tyre Pres Rear", "kPa", Some(TyrePressureRear)), ("", "Brake Temp Front", "C", None), ("", "Engine Speed", "rpm", None),
        ("", "Fuel Pres", "kPa", None), ("", "Lap Distance", "m", None), ("", "Wheelspeed Slip", "%", None),
    ]),
    ("RaceChrono", "racechrono", &[
        ("gps", "speed", "m/s", Some(VelocityX)), ("gps", "accuracy", "m", None), ("gps", "altitude", "m", Some(Altitude)),
        ("gps", "bearing", "deg", Some(Yaw)), ("gps", "device_battery_level", "%", None), ("gps", "device_update_rate", "Hz", None),
        ("gps", "latitude", "deg", Some(Latitude)), ("gps", "longitude", "deg", Some(Longitude)), ("gps", "satellites", "", None),
        ("calc", "combined_acc", "G", None), ("calc", "lateral_acc", "G", Some(AccelerationY)), ("calc", "lean_angle", "deg", None),
        ("calc", "longitudinal_acc", "G", Some(AccelerationX)), ("acc", "x_acc", "G", None), ("acc", "y_acc", "G", None), ("acc", "z_acc", "G", None),
        ("gyro", "x_rate_of_rotation", "deg/s", None), ("gyro", "z_rate_of_rotation", "deg/s", None),
        ("canbus", "brake_pressure_front", "kPa", Some(BrakePressureFront)), ("canbus", "wheel_speed_rear", "km/h", Some(WheelSpeedRear)),
        ("canbus", "gear", "", Some(Gear)), ("canbus", "ambient_temp", ".C", Some(AirTemperature)), ("obd", "throttle_pos", "%", Some(Throttle)),
        ("obd", "coolant_temp", ".C", None), ("obd", "rpm", "rpm", None), ("obd", "intake_temp", ".C", None), ("calc", "distance_traveled", "m", None),
    ]),
    ("Racelogic VBOX", "vbo", &[
        ("", "sats", "", None), ("", "lat", "deg", Some(Latitude)), ("", "long", "deg", Some(Longitude)), ("", "velocity", "km/h", Some(VelocityX)),
        ("", "heading", "deg", Some(Yaw)), ("", "height", "m", Some(Altitude)), ("", "vert-vel", "km/h", None), ("", "Longacc", "g", Some(AccelerationX)),
        ("", "Latacc", "g", Some(AccelerationY)), ("", "Yaw_Rate", "deg/s", Some(YawRate)), ("", "Wheel_Speed_Front", "km/h", Some(WheelSpeedFront)),
        ("", "Brake_Pressure_Front", "bar", Some(BrakePressureFront)), ("", "Solution_type", "", None), ("", "velocity_quality", "km/h", None),
        ("", "RadiusOfTurn", "m", None), ("", "Trigger_time", "s", None), ("", "lean_calc", "deg", None),
    ]),
    ("Bosch MM5.10 and MSC on the bus", "can", &[
        ("MM5_10_TX1", "YAW_RATE", "°/s", Some(YawRate)), ("MM5_10_TX1", "AY", "g", Some(AccelerationY)), ("MM5_10_TX2", "ROLL_RATE", "°/s", Some(RollRate)),
        ("MM5_10_TX2", "AX", "g", Some(AccelerationX)), ("MM5_10_TX3", "PITCH_RATE", "°/s", Some(PitchRate)), ("MM5_10_TX3", "AZ", "g", None),
        ("MM5_10_TX1", "YAW_RATE_STATE", "", None), ("MM5_10_TX1", "CLU_DIAG", "", None), ("MSC", "BankAngle", "deg", Some(Roll)),
        ("MSC", "PitchAngle", "deg", Some(Pitch)), ("MSC", "BankAngle_Valid", "", None), ("ABS", "WheelSpeedFront", "km/h", Some(WheelSpeedFront)),
        ("ABS", "WheelSpeedRear", "km/h", Some(WheelSpeedRear)), ("ABS", "PressureMasterCylinderFront", "bar", Some(BrakePressureFront)),
        ("ABS", "PressureMasterCylinderRear", "bar", Some(BrakePressureRear)), ("ABS", "AbsLampRequest", "", None),
    ]),
    ("Y-Trac CTRK", "ctrk", &[
        ("", "gear", "1", Some(Gear)), ("", "throttle", "%", Some(Throttle)), ("", "throttle_grip", "%", Some(Throttle)), ("", "acc_x_g", "g", Some(AccelerationX)),
        ("", "acc_y_g", "g", Some(AccelerationY)), ("", "lean_raw_deg", "deg", None), ("", "lean_signed_deg", "deg", Some(Roll)),
        ("", "pitch_deg_s", "deg/s", Some(PitchRate)), ("", "front_brake_bar", "bar", Some(BrakePressureFront)), ("", "rear_brake_bar", "bar", Some(BrakePressureRear)),
        ("", "front_speed_kmh", "km/h", Some(WheelSpeedFront)), ("", "rear_speed_kmh", "km/h", Some(WheelSpeedRear)), ("", "f_abs", "1", None),
        ("", "launch", "1", None), ("", "intake_temp", "degC", None), ("", "gps_speed_kmh", "km/h", Some(VelocityX)), ("", "gps_course_deg", "deg", Some(Yaw)),
        ("", "fuel_cc", "cc", None), ("", "tcs", "1", None),
    ]),
    ("2D Datarecording", "csv", &[
        ("", "V_GPS", "km/h", Some(VelocityX)), ("", "V_Front", "km/h", Some(WheelSpeedFront)), ("", "V_Rear", "km/h", Some(WheelSpeedRear)),
        ("", "P_Brake_Front", "bar", Some(BrakePressureFront)), ("", "P_Brake_Rear", "bar", Some(BrakePressureRear)), ("", "Susp_Front", "mm", Some(ForkTravel)),
        ("", "Susp_Rear", "mm", Some(ShockTravel)), ("", "Banking", "°", Some(Roll)), ("", "Gyro_Z", "°/s", Some(YawRate)), ("", "Gyro_X", "°/s", Some(RollRate)),
        ("", "Acc_X", "g", Some(AccelerationX)), ("", "Acc_Y", "g", Some(AccelerationY)), ("", "Acc_Z", "g", None), ("", "TPS1", "%", Some(Throttle)),
        ("", "V_Bat", "V", None), ("", "V_Front_raw", "", None), ("", "Steering_Angle", "°", Some(SteerAngle)), ("", "T_Air", "°C", Some(AirTemperature)),
        ("", "Speed_Diff", "km/h", None), ("", "Gear_Voltage", "mV", None),
    ]),
    ("Race Technology", "csv", &[
        ("", "GPS speed", "m/s", Some(VelocityX)), ("", "Longitudinal accel", "g", Some(AccelerationX)), ("", "Lateral accel", "g", Some(AccelerationY)),
        ("", "GPS heading", "degrees", Some(Yaw)), ("", "GPS altitude", "m", Some(Altitude)), ("", "GPS speed accuracy", "m/s", None), ("", "GPS position accuracy", "m", None),
        ("", "Yaw rate", "deg/s", Some(YawRate)), ("", "Front wheel speed", "m/s", Some(WheelSpeedFront)), ("", "Pseudo lean angle", "degrees", None),
        ("", "GPS lateral accel", "g", Some(AccelerationY)), ("", "Brake front pressure", "bar", Some(BrakePressureFront)),
    ]),
    ("Torque, OBD", "csv", &[
        ("", "GPS Speed (Meters/second)", "Meters/second", Some(VelocityX)), ("", "Latitude", "", Some(Latitude)), ("", "Longitude", "", Some(Longitude)),
        ("", "Altitude", "m", Some(Altitude)), ("", "Bearing", "", Some(Yaw)), ("", "G(x)", "", None), ("", "Acceleration Sensor(X axis)(g)", "g", None),
        ("", "Acceleration Sensor(Total)(g)", "g", None), ("", "Accelerator PedalPosition D(%)", "%", Some(Throttle)), ("", "Throttle Position(Manifold)(%)", "%", Some(Throttle)),
        ("", "Ambient air temp(°C)", "°C", Some(AirTemperature)), ("", "Intake Air Temperature(°C)", "°C", None), ("", "Engine RPM(rpm)", "rpm", None),
        ("", "Average trip speed(whilst moving only)(km/h)", "km/h", None), ("", "GPS vs OBD Speed difference(km/h)", "km/h", None),
        ("", "Commanded throttle actuator(%)", "%", None), ("", "Engine Load(%)", "%", None), ("", "Barometric pressure (from vehicle)(psi)", "psi", None),
        ("", "Timing Advance(°)", "°", None), ("", "Turbo Boost & Vacuum Gauge(psi)", "psi", None), ("", "GPS Accuracy(m)", "m", None),
    ]),
    ("RaceBox", "racebox", &[
        ("", "Latitude", "deg", Some(Latitude)), ("", "Longitude", "deg", Some(Longitude)), ("", "Altitude (m)", "m", Some(Altitude)), ("", "Speed", "km/h", Some(VelocityX)),
        ("", "GForceX", "g", Some(AccelerationX)), ("", "GForceY", "g", Some(AccelerationY)), ("", "GForceZ", "g", None), ("", "GyroX", "deg/s", Some(RollRate)),
        ("", "GyroY", "deg/s", Some(PitchRate)), ("", "GyroZ", "deg/s", Some(YawRate)), ("", "Heading", "deg", Some(Yaw)), ("", "Lap", "", Some(LapNumber)), ("", "Record", "", None),
    ]),
];

fn listing(channels: &[Named]) -> Listing {
    let channel = |&(group, name, unit, _): &Named| SourceChannel {
        group: group.into(),
        name: name.into(),
        unit: (!unit.is_empty()).then(|| unit.to_owned()),
        ..SourceChannel::default()
    };
    Listing { channels: channels.iter().map(channel).collect(), ..Listing::default() }
}

#[test]
fn channels_of_real_loggers_are_offered_for_their_columns() {
    let (mut named, mut right, mut traps) = (0, 0, 0);
    let (mut missed, mut wrong) = (Vec::new(), Vec::new());
    for (logger, format, channels) in LOGGERS {
        let log = listing(channels);
        let offered: Vec<(Channel, Vec<Candidate<'_>>)> =
            RULES.iter().map(|r| (r.channel, candidates(r, format, &log, &[]))).collect();
        for (channel, &(_, name, _, wanted)) in log.channels.iter().zip(*channels) {
            let of = |column: Channel| {
                let among = offered.iter().find(|o| o.0 == column).expect("a rule");
                among.1.iter().take(MAX_OFFERED).find(|c| std::ptr::eq(c.channel, channel))
            };
            match wanted {
                None => traps += 1,
                Some(column) => {
                    named += 1;
                    right += usize::from(of(column).is_some());
                    if of(column).is_none() {
                        missed.push(format!("{logger}: {name} as {column}"));
                    }
                }
            }
            for (column, _) in &offered {
                let sure = of(*column).is_some_and(|c| c.doubt.is_none());
                if sure && wanted != Some(*column) {
                    wrong.push(format!("{logger}: {name} as {column}"));
                }
            }
        }
    }
    println!("{right} of {named} offered for their column, {traps} traps; missed: {missed:#?}");
    assert!(wrong.is_empty(), "taken without a doubt: {wrong:#?}");
    assert!(named >= 80 && traps >= 80, "{named} names, {traps} traps");
    assert!(right as f64 >= RIGHT * named as f64, "missed {missed:#?}");
}

#[test]
fn the_grip_and_the_valve_are_not_told_apart() {
    for (log, sure) in [
        (&[("", "throttle_grip", "%", None), ("", "throttle", "%", None)][..], 0),
        (&[("", "APS", "%", None), ("", "TPS", "%", None)], 0),
        (
            &[
                ("", "Throttle Grip Position", "%", None),
                ("", "Throttle Valve Position", "%", None),
            ],
            0,
        ),
        (&[("", "Throttle Grip", "%", None)], 1),
        (&[("", "TPS", "%", None), ("", "TPS Target", "%", None)], 1),
    ] {
        let listing = listing(log);
        let rule = RULES.iter().find(|r| r.channel == Throttle).expect("a rule");
        let found = candidates(rule, "csv", &listing, &[]);
        assert_eq!(found.iter().filter(|c| c.doubt.is_none()).count(), sure, "{log:?}");
    }
}
