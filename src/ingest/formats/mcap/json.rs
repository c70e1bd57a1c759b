//! Numbers of a JSON message.

use serde_json::Value;

use super::fault::Fault;
use super::limits::LISTED;

/// Every number (and truth value) by its path.
pub(super) fn numbers(data: &[u8], take: &mut dyn FnMut(&str, f64)) -> Result<(), Fault> {
    let value: Value = serde_json::from_slice(data).map_err(|e| Fault::from(e.to_string()))?;
    walk(&value, &mut String::new(), take);
    Ok(())
}

/// Not deeper than serde_json reads.
fn walk(value: &Value, path: &mut String, take: &mut dyn FnMut(&str, f64)) {
    let length = path.len();
    let mut below = |path: &mut String, name: &str, value: &Value| {
        if !path.is_empty() {
            path.push('.');
        }
        path.push_str(name);
        walk(value, path, take);
        path.truncate(length);
    };
    match value {
        Value::Object(fields) => fields.iter().for_each(|(name, value)| below(path, name, value)),
        Value::Array(list) if list.len() <= LISTED => {
            list.iter().enumerate().for_each(|(i, value)| below(path, &i.to_string(), value));
        }
        Value::Number(number) => take(path, number.as_f64().unwrap_or(f64::NAN)),
        Value::Bool(truth) => take(path, f64::from(u8::from(*truth))),
        Value::Null => take(path, f64::NAN),
        Value::Array(_) | Value::String(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_wherever_they_are() {
        let mut found = Vec::new();
        let text = br#"{"a":{"b":1.5,"c":[2,true]},"d":"text","e":null}"#;
        numbers(text, &mut |path, value| found.push((path.to_owned(), value))).expect("JSON");
        assert_eq!(found.len(), 4);
        assert_eq!(found[0], ("a.b".into(), 1.5));
        assert_eq!(found[2], ("a.c.1".into(), 1.0));
        assert!(found[3].1.is_nan() && found[3].0 == "e");
        assert!(numbers(b"{\"a\":", &mut |_, _| {}).is_err());
    }
}
