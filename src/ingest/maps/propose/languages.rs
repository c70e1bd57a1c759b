//! Words of other languages that loggers' names are made of, as English ones.

/// Beginnings of words in lower case without accents, and the English words for them. A word of the table that ends with
/// `$` must be whole. The longest that fits counts.
#[rustfmt::skip]
const WORDS: &[(&str, &str)] = &[
    // speed
    ("geschwindigkeit", "speed"), ("fahrgeschwindigkeit", "speed"),
    ("vitesse", "speed"), ("velocita", "speed"), ("velocidad", "speed"), ("velocidade", "speed"), ("snelheid", "speed"),
    ("predkosc", "speed"), ("szybkosc", "speed"), ("hastighe", "speed"), ("fart$", "speed"), ("nopeus", "speed"), ("rychlost", "speed"),
    ("sebesseg", "speed"), ("viteza", "speed"), ("hiz$", "speed"), ("brzina", "speed"), ("скорост", "speed"),
    ("ταχυτητα", "speed"), ("速度", "speed"), ("车速", "speed"), ("속도", "speed"), ("raddrehzahl", "wheel speed"),
    ("radgeschwindigkeit", "wheel speed"), ("radspeed", "wheel speed"), ("vorderradgeschwindigkeit", "wheel speed front"),
    ("hinterradgeschwindigkeit", "wheel speed rear"), ("vorderraddrehzahl", "wheel speed front"),
    ("hinterraddrehzahl", "wheel speed rear"), ("wielsnelheid", "wheel speed"),
    // Russian, Japanese and Chinese: what is written in one word is one entry
    ("передн", "front"), ("задн", "rear"), ("колес", "wheel"), ("давлени", "pressure"), ("тормоз", "brake"),
    ("дроссел", "throttle"), ("передача$", "gear"), ("前輪速", "wheel speed front"), ("後輪速", "wheel speed rear"),
    ("前ブレーキ", "brake pressure front"), ("後ブレーキ", "brake pressure rear"), ("ブレーキ液圧", "brake pressure"),
    ("前$", "front"), ("後$", "rear"), ("スロットル", "throttle"), ("ギア$", "gear"), ("ギヤ$", "gear"),
    ("方位", "heading"), ("リーン角", "lean angle"), ("前轮速", "wheel speed front"), ("后轮速", "wheel speed rear"),
    ("前刹车", "brake pressure front"), ("后刹车", "brake pressure rear"), ("油门", "throttle"), ("档位", "gear"),
    ("挡位", "gear"), ("航向", "heading"),
    // wheels and ends
    ("vorderrad", "wheel front"), ("hinterrad", "wheel rear"), ("roue", "wheel"), ("ruota", "wheel"),
    ("rueda", "wheel"), ("roda$", "wheel"), ("wiel$", "wheel"), ("voorwiel", "wheel front"), ("achterwiel", "wheel rear"),
    ("kolo$", "wheel"), ("kola$", "wheel"), ("hjul", "wheel"), ("framhjul", "wheel front"), ("bakhjul", "wheel rear"),
    ("forhjul", "wheel front"), ("baghjul", "wheel rear"), ("vorn$", "front"), ("vorne$", "front"), ("vorder", "front"),
    ("hinten", "rear"), ("hinter", "rear"), ("avant$", "front"), ("arriere", "rear"),
    ("anteriore", "front"), ("posteriore", "rear"), ("anterior", "front"), ("posterior", "rear"), ("delanter", "front"),
    ("traser", "rear"), ("dianteir", "front"), ("traseir", "rear"), ("voor$", "front"), ("achter$", "rear"), ("przod", "front"),
    ("przedni", "front"), ("przednie", "front"), ("tyl$", "rear"), ("tyln", "rear"), ("fram$", "front"), ("bak$", "rear"),
    ("predni", "front"), ("zadni", "rear"), ("etu$", "front"), ("taka$", "rear"),
    // position
    ("breitengrad", "latitude"), ("geobreite", "latitude"), ("breite$", "latitude"),
    ("langengrad", "longitude"), ("laengengrad", "longitude"), ("lange$", "longitude"), ("laenge$", "longitude"),
    ("latitud", "latitude"), ("latitudine", "latitude"), ("longitudine", "longitude"), ("longitud$", "longitude"),
    ("breedtegraad", "latitude"), ("lengtegraad", "longitude"), ("breedte$", "latitude"), ("lengte$", "longitude"),
    ("szerokosc", "latitude"), ("dlugosc", "longitude"), ("breddegrad", "latitude"), ("bredde$", "latitude"),
    ("lengdegrad", "longitude"), ("langdegrad", "longitude"), ("laengdegrad", "longitude"), ("leveysaste", "latitude"),
    ("pituusaste", "longitude"), ("sirka$", "latitude"), ("delka$", "longitude"), ("szelesseg", "latitude"), ("hosszusag", "longitude"),
    ("enlem", "latitude"), ("boylam", "longitude"), ("широта", "latitude"), ("долгота", "longitude"), ("纬度", "latitude"),
    ("经度", "longitude"), ("緯度", "latitude"), ("経度", "longitude"), ("위도", "latitude"), ("경도", "longitude"),
    ("hohe$", "altitude"), ("hoehe$", "altitude"), ("altezza", "altitude"), ("altura$", "altitude"), ("altitud$", "altitude"),
    ("quota$", "altitude"), ("hoogte", "altitude"), ("wysokosc", "altitude"), ("hojd$", "altitude"), ("hoyde$", "altitude"),
    ("korkeus", "altitude"), ("vyska$", "altitude"), ("высота", "altitude"), ("海拔", "altitude"), ("kurs$", "course"),
    ("richtung", "course"), ("fahrtrichtung", "course"), ("peilung", "bearing"), ("cap$", "heading"),
    ("direzione", "course"), ("rotta$", "course"), ("rumbo", "course"), ("direccion", "course"), ("rumo$", "course"),
    ("direcao", "course"), ("koers", "course"), ("richting", "course"), ("kierunek", "course"), ("azimut", "bearing"),
    ("smer$", "course"), ("riktning", "course"), ("курс", "course"),
    // lean and its like
    ("schraglage", "lean"), ("schraeglage", "lean"), ("schraglagenwinkel", "lean angle"), ("neigung", "lean"),
    ("neigungswinkel", "lean angle"), ("rollwinkel", "roll angle"), ("wankwinkel", "roll angle"), ("inclinaison", "lean"),
    ("piega$", "lean"), ("inclinazione", "lean"), ("rollio", "roll"), ("inclinacion", "lean"),
    ("inclinacao", "lean"), ("hellingshoek", "lean angle"), ("helling", "lean"), ("rolhoek", "roll angle"), ("pochylenie", "lean"),
    ("przechyl", "lean"), ("lutning", "lean"), ("kallistus", "lean"), ("naklon", "lean"), ("dolesszog", "lean angle"),
    ("yatis$", "lean"), ("крен", "lean"), ("наклон", "lean"), ("バンク角", "lean angle"), ("倾角", "lean angle"),
    ("nickwinkel", "pitch angle"), ("tangage", "pitch"), ("beccheggio", "pitch"), ("cabeceo", "pitch"), ("gierwinkel", "yaw angle"),
    ("lacet$", "yaw"), ("imbardata", "yaw"), ("gierrate", "yaw rate"), ("rollrate$", "roll rate"), ("nickrate", "pitch rate"),
    ("wankrate", "roll rate"), ("gierwinkelgeschwindigkeit", "yaw rate"), ("drehrate", "rate"), ("winkel$", "angle"),
    ("angolo", "angle"), ("angulo", "angle"), ("hoek$", "angle"), ("lenkwinkel", "steering angle"),
    ("lenker", "handlebar"), ("sterzo", "steering"), ("guidon", "handlebar"), ("manillar", "handlebar"), ("stuurhoek", "steering angle"),
    // accelerations
    ("beschleunigung", "acceleration"), ("langsbeschleunigung", "longitudinal acceleration"),
    ("laengsbeschleunigung", "longitudinal acceleration"), ("querbeschleunigung", "lateral acceleration"),
    ("seitenbeschleunigung", "lateral acceleration"), ("langs$", "longitudinal"), ("laengs$", "longitudinal"), ("quer$", "lateral"),
    ("accelerazione", "acceleration"), ("aceleracion", "acceleration"), ("aceleracao", "acceleration"), ("versnelling$", "gear"),
    ("przyspieszenie", "acceleration"), ("laterale$", "lateral"), ("longitudinale$", "longitudinal"),
    // controls
    ("bremsdruck", "brake pressure"), ("bremse", "brake"), ("vorderradbremse", "brake front"), ("hinterradbremse", "brake rear"),
    ("druck$", "pressure"), ("frein", "brake"), ("pression", "pressure"), ("freno", "brake"), ("pressione", "pressure"),
    ("presion", "pressure"), ("freio", "brake"), ("pressao", "pressure"), ("remdruk", "brake pressure"),
    ("druk$", "pressure"), ("hamulec", "brake"), ("hamulca", "brake"), ("cisnienie", "pressure"), ("broms", "brake"),
    ("gasgriff", "grip"), ("gasstellung", "throttle"), ("gaspedal", "throttle"), ("drosselklappe", "throttle"), ("papillon", "throttle"), ("accelerateur", "throttle"),
    ("acceleratore", "throttle"), ("farfalla", "throttle"), ("acelerador", "throttle"), ("mariposa", "throttle"),
    ("gashendel", "grip"), ("gasklep", "throttle"), ("przepustnica", "throttle"), ("gang$", "gear"), ("rapport$", "gear"),
    ("marcia", "gear"), ("marcha", "gear"), ("bieg$", "gear"), ("vaxel", "gear"), ("runde$", "lap"), ("rundennummer", "lap number"),
    ("tour$", "lap"), ("giro$", "lap"), ("vuelta", "lap"), ("volta$", "lap"), ("ronde$", "lap"), ("okrazenie", "lap"), ("varv$", "lap"),
    ("drehzahl", "engine rpm"), ("motordrehzahl", "engine rpm"), ("regime$", "engine rpm"), ("federweg", "suspension"),
    ("lufttemperatur", "air temperature"), ("aussentemperatur", "ambient temperature"), ("außentemperatur", "ambient temperature"),
    ("reifentemperatur", "tyre temperature"), ("reifen", "tyre"), ("pneu", "tyre"), ("pneumatico", "tyre"), ("neumatico", "tyre"),
    // what is none
    ("genauigkeit", "accuracy"), ("precision$", "accuracy"), ("precisione", "accuracy"), ("exactitud", "accuracy"),
    ("nauwkeurigheid", "accuracy"), ("dokladnosc", "accuracy"), ("entfernung", "distance"), ("strecke", "distance"),
    ("distanz", "distance"), ("distancia", "distance"), ("distanza", "distance"), ("afstand", "distance"), ("soll$", "target"),
    ("maximal", "max"), ("durchschnitt", "average"), ("mittel", "average"), ("moyenne", "average"), ("media$", "average"),
    ("fehler", "error"), ("motor$", "engine"), ("moteur", "engine"), ("motore", "engine"), ("vent$", "wind"), ("viento", "wind"),
];

/// The English words for a word of another language, in lower case without accents; `None` of words that are not known.
pub(super) fn english(word: &str) -> Option<&'static str> {
    if word.len() < 2 {
        return None;
    }
    let fits = |known: &str| match known.strip_suffix('$') {
        Some(whole) => word == whole,
        None => word.starts_with(known),
    };
    let found = WORDS.iter().filter(|(known, _)| fits(known));
    found.max_by_key(|(known, _)| known.trim_end_matches('$').len()).map(|w| w.1)
}
