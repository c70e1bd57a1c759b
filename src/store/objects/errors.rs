//! Errors of object stores in plain words, with what to set.

use std::io::{Error, ErrorKind, Result};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use object_store::aws::AmazonS3ConfigKey;

use super::url::{Scheme, Url};

/// The server from which machines at Amazon get their credentials, and the timeout of its probe.
const METADATA: (&str, u16, Duration) = ("169.254.169.254", 80, Duration::from_secs(1));

/// Which variables hold the credentials.
fn variables(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::S3 => "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY (and AWS_SESSION_TOKEN)",
        Scheme::Gs => "GOOGLE_SERVICE_ACCOUNT or GOOGLE_APPLICATION_CREDENTIALS",
        Scheme::Az => "AZURE_STORAGE_ACCOUNT_NAME and AZURE_STORAGE_ACCOUNT_KEY",
    }
}

/// Whether a repeated request may succeed.
pub(super) fn is_transient(error: &object_store::Error) -> bool {
    match error {
        object_store::Error::Generic { .. } => {
            // answers that will be the same next time: all that blame the request
            let text = error.to_string();
            let refused = text.contains("status code: 4")
                && !["408", "429"].iter().any(|n| text.contains(&format!("status code: {n}")));
            let lasting = ["status code: 501", "redirect", "builder error", METADATA.0];
            !refused && !lasting.iter().any(|words| text.contains(words))
        }
        _ => false,
    }
}

/// The error with its remedy; its kind is what callers branch on.
pub(super) fn explain(url: &Url, error: object_store::Error) -> Error {
    use object_store::Error as E;
    let names = variables(url.scheme);
    let text = error.to_string();
    let bucket = format!("{}://{}", url.scheme.name(), url.bucket);
    // for a listing the crate gives the status in its text only
    let status = |n: &str| text.contains(&format!("status code: {n}"));
    let denied = matches!(error, E::PermissionDenied { .. }) || status("403");
    let unknown = matches!(error, E::Unauthenticated { .. }) || status("401");
    let (kind, message) = match error {
        _ if ["NoSuchBucket", "ContainerNotFound"].iter().any(|code| text.contains(code)) => (
            ErrorKind::InvalidInput,
            format!("{url}: there is no bucket {bucket}; correct the URL"),
        ),
        _ if text.contains(METADATA.0) => (ErrorKind::PermissionDenied, no_credentials()),
        E::NotFound { .. } => (ErrorKind::NotFound, format!("{url} does not exist")),
        _ if denied => (
            ErrorKind::PermissionDenied,
            format!(
                "{url}: permission denied (403); set credentials that may do this in {names}: \
                 inputs need list and get, --out also put and delete{}",
                reason(&text)
            ),
        ),
        _ if unknown => (
            ErrorKind::PermissionDenied,
            format!("{url}: the credentials are not accepted (401); set {names}"),
        ),
        E::AlreadyExists { .. } => (ErrorKind::AlreadyExists, format!("{url} exists already")),
        E::Precondition { .. } => (
            ErrorKind::AlreadyExists,
            format!("{url} was overwritten while it was in use; run again"),
        ),
        E::NotImplemented { .. } | E::NotSupported { .. } => (
            ErrorKind::Unsupported,
            format!("{url}: the store does not support this request: {text}"),
        ),
        _ => (ErrorKind::Other, format!("{url}: {}{}", text.trim(), advice(url, &text))),
    };
    Error::new(kind, message)
}

/// The store's own word for a refusal.
fn reason(text: &str) -> String {
    let code = text.split_once("<Code>").and_then(|(_, rest)| rest.split_once("</Code>"));
    code.map(|(code, _)| format!(" (the store says {code})")).unwrap_or_default()
}

fn advice(url: &Url, text: &str) -> &'static str {
    if url.scheme != Scheme::S3 {
        return "";
    }
    if text.contains("redirect") {
        "; set AWS_REGION to the bucket's region"
    } else if text.contains("URL scheme is not allowed") || text.contains("builder error") {
        "; for an endpoint without TLS set AWS_ALLOW_HTTP=true"
    } else {
        ""
    }
}

/// Whether there is anything to sign requests with. Without any, the client would ask a server
/// that only machines at Amazon have, for minutes.
///
/// # Errors
/// There is not, and no such server.
pub(super) fn credentials_at_hand(
    setting: &dyn Fn(AmazonS3ConfigKey) -> Option<String>,
) -> Result<()> {
    use AmazonS3ConfigKey as Key;
    let one_of = [
        Key::AccessKeyId,
        Key::SecretAccessKey,
        Key::WebIdentityTokenFile,
        Key::ContainerCredentialsRelativeUri,
        Key::ContainerCredentialsFullUri,
        Key::MetadataEndpoint,
    ];
    let unsigned = setting(Key::SkipSignature).is_some_and(|v| v == "true");
    if unsigned || one_of.into_iter().any(|key| setting(key).is_some()) {
        return Ok(());
    }
    let disabled = std::env::var("AWS_EC2_METADATA_DISABLED").is_ok_and(|v| v == "true");
    let (server, port, patience) = METADATA;
    let mut places = (server, port).to_socket_addrs()?;
    if !disabled && places.any(|at| TcpStream::connect_timeout(&at, patience).is_ok()) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::PermissionDenied, no_credentials()))
}

fn no_credentials() -> String {
    format!(
        "no credentials for s3://: set {}, or AWS_SKIP_SIGNATURE=true for a public bucket",
        variables(Scheme::S3)
    )
}
