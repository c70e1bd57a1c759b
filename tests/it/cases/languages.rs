//! Names of other languages, and units anywhere in a name.

use super::Expected::Right;
use super::*;

fn names(what: &'static str, names: [&str; 5]) -> Case {
    let text = plain();
    let (_, rows) = text.split_once('\n').expect("rows");
    case(what, format!("{}\n{rows}", names.join(",")), Right)
}

#[test]
fn names_of_other_languages() {
    hold(vec![
        names(
            "German",
            ["Zeit (s)", "Geschwindigkeit (km/h)", "Breitengrad", "Längengrad", "Schräglage (°)"],
        ),
        names(
            "German without dots",
            ["Zeit", "GPS-Geschwindigkeit", "Breite", "Laenge", "Schraeglage"],
        ),
        names(
            "French",
            ["Temps (s)", "Vitesse (km/h)", "Latitude", "Longitude", "Angle d'inclinaison (°)"],
        ),
        names(
            "Italian",
            ["Tempo (s)", "Velocità (km/h)", "Latitudine", "Longitudine", "Piega (°)"],
        ),
        names(
            "Spanish",
            ["Tiempo (s)", "Velocidad (km/h)", "Latitud", "Longitud", "Inclinación (°)"],
        ),
        names(
            "Portuguese",
            ["Tempo (s)", "Velocidade (km/h)", "Latitude", "Longitude", "Inclinação (°)"],
        ),
        names(
            "Dutch",
            ["Tijd (s)", "Snelheid (km/u)", "Breedtegraad", "Lengtegraad", "Hellingshoek (°)"],
        ),
        names("Polish", ["Czas (s)", "Prędkość (km/h)", "Szerokość", "Długość", "Pochylenie (°)"]),
        names("Swedish", ["Tid (s)", "Hastighet (km/h)", "Latitud", "Longitud", "Lutning (°)"]),
        names(
            "Czech",
            ["Čas (s)", "Rychlost (km/h)", "Zeměpisná šířka", "Zeměpisná délka", "Náklon (°)"],
        ),
        names("Russian", ["Время (с)", "Скорость (км/ч)", "Широта", "Долгота", "Крен (°)"]),
        names("Chinese", ["时间", "速度 (km/h)", "纬度", "经度", "倾角"]),
    ]);
}

#[test]
fn units_in_names() {
    hold(vec![
        names(
            "square brackets",
            ["Time [s]", "Speed [km/h]", "Latitude [deg]", "Longitude [deg]", "Lean [deg]"],
        ),
        names(
            "braces",
            ["Time {s}", "Speed {km/h}", "Latitude {deg}", "Longitude {deg}", "Lean {deg}"],
        ),
        names("suffixes", ["time_s", "speed_kmh", "lat_deg", "lon_deg", "lean_deg"]),
        names(
            "behind a dash",
            ["Time - s", "Speed - km/h", "Latitude - deg", "Longitude - deg", "Lean - deg"],
        ),
        names("nothing but a unit", ["Seconds", "Km/h", "Latitude", "Longitude", "Lean"]),
        names("without units", ["time", "speed", "lat", "lng", "lean"]),
        names("a wrong unit", ["Time (s)", "Speed (mph)", "Latitude", "Longitude", "Lean (deg)"]),
    ]);
}
