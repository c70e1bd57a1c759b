//! What a page of the report draws, read back.

use std::io::Read;

use base64::Engine;

/// The JSON in a page; its columns stay steps, `{"e": .., "d": [..]}`.
pub fn data(html: &str) -> serde_json::Value {
    let packed = html
        .split("id=\"data\">")
        .nth(1)
        .and_then(|rest| rest.split("</script>").next())
        .expect("a page that draws something");
    let bytes = base64::engine::general_purpose::STANDARD.decode(packed).expect("base64");
    let mut json = String::new();
    flate2::read::ZlibDecoder::new(&bytes[..]).read_to_string(&mut json).expect("zlib");
    serde_json::from_str(&json).expect("JSON")
}
