//! A small S3 in memory on the loopback, with faults on request: as much of the protocol as
//! `object_store` speaks, a thread per connection.
//!
//! Faults are drawn by a seeded generator. They end once a number of them is spent, so that a test
//! does.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Result, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use md5::{Digest, Md5};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Objects of one listing's page: few, so that listings have pages.
const PAGE: usize = 50;

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// The answer takes longer than the client waits.
    Hung,
    /// The answer takes its time.
    Slow,
    /// 500.
    Broken,
    /// 503, `SlowDown`.
    Busy,
    /// The connection is closed before anything is done.
    Reset,
    /// It is done, and the connection closed instead of an answer.
    Lost,
    /// Half of the answer's body, then nothing more.
    Torn,
}

const FAULTS: [Fault; 7] =
    [Fault::Hung, Fault::Slow, Fault::Broken, Fault::Busy, Fault::Reset, Fault::Lost, Fault::Torn];

/// One request, as it came.
#[derive(Debug, Clone)]
pub struct Seen {
    /// `GET`, ...; a listing is `LIST`.
    pub method: String,
    /// The object, where it is about one.
    pub key: String,
    /// The part that was asked for.
    pub range: Option<String>,
    /// What was done to it.
    pub fault: Option<Fault>,
}

#[derive(Debug, Clone)]
struct Object {
    bytes: Arc<Vec<u8>>,
    etag: String,
}

#[derive(Debug)]
struct Faults {
    random: Pcg64,
    rate: f64,
    left: usize,
}

#[derive(Debug)]
struct State {
    objects: Mutex<BTreeMap<String, Object>>,
    seen: Mutex<Vec<Seen>>,
    faults: Mutex<Faults>,
    written: Mutex<u64>,
    /// Whether an object's name is the MD5 of its bytes, and every which body loses a bit on its way.
    checksums: AtomicBool,
    flips: AtomicUsize,
    bodies: AtomicUsize,
}

/// The server, with one bucket: `fleet`. It serves until the test ends.
#[derive(Debug, Clone)]
pub struct Server {
    address: String,
    state: Arc<State>,
}

struct Request {
    method: String,
    key: String,
    bucket: String,
    query: String,
    headers: BTreeMap<String, String>,
    body: Vec<u8>,
}

struct Answer {
    status: &'static str,
    headers: Vec<(&'static str, String)>,
    body: Vec<u8>,
    /// Of a HEAD: a length without a body.
    length: Option<usize>,
}

impl Server {
    /// Starts it.
    pub fn start() -> Server {
        let listener = TcpListener::bind("127.0.0.1:0").expect("loopback");
        let address = listener.local_addr().expect("address").to_string();
        let state = Arc::new(State {
            objects: Mutex::default(),
            seen: Mutex::default(),
            faults: Mutex::new(Faults { random: Pcg64::seed_from_u64(0), rate: 0.0, left: 0 }),
            written: Mutex::default(),
            checksums: AtomicBool::default(),
            flips: AtomicUsize::default(),
            bodies: AtomicUsize::default(),
        });
        let served = Arc::clone(&state);
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let state = Arc::clone(&served);
                std::thread::spawn(move || {
                    let _ = serve(&stream, &state); // a client that is gone is no failure
                });
            }
        });
        Server { address, state }
    }

    /// Another server with the same objects by the same names: what is done there is not seen here.
    pub fn twin(&self) -> Server {
        let twin = Server::start();
        let objects = self.state.objects.lock().expect("lock").clone();
        *twin.state.objects.lock().expect("lock") = objects;
        *twin.state.written.lock().expect("lock") = *self.state.written.lock().expect("lock");
        let is_checksum = self.state.checksums.load(Ordering::Relaxed);
        twin.state.checksums.store(is_checksum, Ordering::Relaxed);
        twin
    }

    /// The environment of a client.
    pub fn environment(&self) -> Vec<(&'static str, String)> {
        vec![
            ("AWS_ENDPOINT_URL", format!("http://{}", self.address)),
            ("AWS_ALLOW_HTTP", "true".into()),
            ("AWS_ACCESS_KEY_ID", "test".into()),
            ("AWS_SECRET_ACCESS_KEY", "test".into()),
            ("AWS_REGION", "us-east-1".into()),
            ("AWS_TIMEOUT", "2s".into()),
        ]
    }

    /// From now on this share of the requests fails, until `most` have.
    pub fn faults(&self, seed: u64, rate: f64, most: usize) {
        *self.state.faults.lock().expect("lock") =
            Faults { random: Pcg64::seed_from_u64(seed), rate, left: most };
    }

    /// From now on objects are named by the MD5 of their bytes, as by S3, and of every `nth` body, whichever way it goes,
    /// one bit is turned; 0 leaves them alone. Gives back how many were turned until now.
    pub fn flips(&self, nth: usize) -> usize {
        self.state.checksums.store(true, Ordering::Relaxed);
        let before = self.state.flips.swap(nth, Ordering::Relaxed);
        let bodies = self.state.bodies.swap(0, Ordering::Relaxed);
        bodies.checked_div(before).unwrap_or(0)
    }

    /// The requests since it was last asked.
    pub fn seen(&self) -> Vec<Seen> {
        std::mem::take(&mut self.state.seen.lock().expect("lock"))
    }

    /// Puts an object there.
    pub fn put(&self, key: &str, bytes: Vec<u8>) {
        self.state.put(key, bytes);
    }

    /// Takes one away.
    pub fn remove(&self, key: &str) {
        self.state.objects.lock().expect("lock").remove(key);
    }

    /// Every object below a prefix, by the rest of its key.
    pub fn below(&self, prefix: &str) -> BTreeMap<String, Arc<Vec<u8>>> {
        let objects = self.state.objects.lock().expect("lock");
        let below = objects.iter().filter_map(|(key, object)| {
            Some((key.strip_prefix(prefix)?.to_owned(), Arc::clone(&object.bytes)))
        });
        below.collect()
    }
}

impl State {
    /// Turns a bit of what goes by, if it is its turn.
    fn turn(&self, body: &mut [u8]) {
        let nth = self.flips.load(Ordering::Relaxed);
        if nth == 0 || body.is_empty() {
            return;
        }
        let n = self.bodies.fetch_add(1, Ordering::Relaxed);
        if n % nth == nth - 1 {
            let at = n.wrapping_mul(7919) % body.len();
            body[at] ^= 1 << (n % 8);
        }
    }

    fn put(&self, key: &str, bytes: Vec<u8>) -> String {
        // like S3's of an upload in parts, it tells nothing of the bytes
        let mut written = self.written.lock().expect("lock");
        *written += 1;
        let etag = match self.checksums.load(Ordering::Relaxed) {
            true => format!("\"{:x}\"", Md5::digest(&bytes)),
            false => format!("\"{:032x}-1\"", *written),
        };
        let object = Object { bytes: Arc::new(bytes), etag: etag.clone() };
        self.objects.lock().expect("lock").insert(key.to_owned(), object);
        etag
    }

    fn draw(&self) -> Option<Fault> {
        let mut faults = self.faults.lock().expect("lock");
        if faults.left == 0 || faults.random.random::<f64>() >= faults.rate {
            return None;
        }
        faults.left -= 1;
        let n = faults.random.random_range(0..FAULTS.len());
        Some(FAULTS[n])
    }
}

fn serve(stream: &TcpStream, state: &State) -> Result<()> {
    let mut reader = BufReader::new(stream.try_clone()?);
    loop {
        let Some(mut request) = receive(&mut reader)? else { return Ok(()) };
        let listing = request.method == "GET" && request.query.contains("list-type=2");
        let method = if listing { "LIST".to_owned() } else { request.method.clone() };
        let fault = state.draw();
        state.seen.lock().expect("lock").push(Seen {
            method,
            key: request.key.clone(),
            range: request.headers.get("range").cloned(),
            fault,
        });
        match fault {
            Some(Fault::Reset) => return Ok(()),
            Some(Fault::Hung) => std::thread::sleep(Duration::from_millis(2600)),
            Some(Fault::Slow) => std::thread::sleep(Duration::from_millis(150)),
            Some(Fault::Broken) => {
                send(stream, &failure("500 Internal Server Error", "InternalError"), false)?;
                continue;
            }
            Some(Fault::Busy) => {
                send(stream, &failure("503 Service Unavailable", "SlowDown"), false)?;
                continue;
            }
            _ => {}
        }
        let is_object = !listing && !request.key.is_empty();
        if is_object && request.method == "PUT" {
            state.turn(&mut request.body);
        }
        let mut answer = state.answer(&request);
        if is_object && request.method == "GET" && answer.status.starts_with("20") {
            state.turn(&mut answer.body);
        }
        match fault {
            Some(Fault::Lost) => return Ok(()),
            Some(Fault::Torn) => return send(stream, &answer, true),
            _ => send(stream, &answer, false)?,
        }
    }
}

fn receive(reader: &mut BufReader<TcpStream>) -> Result<Option<Request>> {
    let mut line = String::new();
    if reader.read_line(&mut line)? == 0 {
        return Ok(None);
    }
    let mut words = line.split_whitespace();
    let (method, target) = (words.next().unwrap_or("").to_owned(), words.next().unwrap_or(""));
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let path = decoded(path.trim_start_matches('/'));
    let (bucket, key) = path.split_once('/').unwrap_or((&path, ""));
    let mut headers = BTreeMap::new();
    loop {
        let mut line = String::new();
        reader.read_line(&mut line)?;
        let line = line.trim_end();
        let Some((name, value)) = line.split_once(':') else { break };
        headers.insert(name.to_ascii_lowercase(), value.trim().to_owned());
    }
    let length = headers.get("content-length").and_then(|l| l.parse().ok()).unwrap_or(0);
    let mut body = vec![0; length];
    reader.read_exact(&mut body)?;
    let (bucket, key, query) = (bucket.to_owned(), key.to_owned(), query.to_owned());
    Ok(Some(Request { method, bucket, key, query, headers, body }))
}

fn send(mut stream: &TcpStream, answer: &Answer, torn: bool) -> Result<()> {
    let length = answer.length.unwrap_or(answer.body.len());
    let mut head = format!("HTTP/1.1 {}\r\ncontent-length: {length}\r\n", answer.status);
    for (name, value) in &answer.headers {
        let _ = write!(head, "{name}: {value}\r\n");
    }
    stream.write_all((head + "\r\n").as_bytes())?;
    let sent = if torn { answer.body.len() / 2 } else { answer.body.len() };
    stream.write_all(&answer.body[..sent])?;
    stream.flush()
}

fn failure(status: &'static str, code: &str) -> Answer {
    let body = format!("<?xml version=\"1.0\"?><Error><Code>{code}</Code></Error>").into_bytes();
    Answer { status, headers: Vec::new(), body, length: None }
}

fn fine(body: Vec<u8>) -> Answer {
    Answer { status: "200 OK", headers: Vec::new(), body, length: None }
}

impl State {
    fn answer(&self, request: &Request) -> Answer {
        let signed = request.headers.get("authorization").map_or("", String::as_str);
        if !signed.contains("Credential=test/") {
            return failure("403 Forbidden", "InvalidAccessKeyId");
        }
        if request.bucket != "fleet" {
            return failure("404 Not Found", "NoSuchBucket");
        }
        match request.method.as_str() {
            "GET" if request.key.is_empty() => self.list(&request.query),
            "GET" | "HEAD" => self.get(request),
            "PUT" => self.put_asked(request),
            "POST" if request.query.starts_with("delete") => self.delete(&request.body),
            "DELETE" => {
                self.objects.lock().expect("lock").remove(&request.key);
                Answer { status: "204 No Content", ..fine(Vec::new()) }
            }
            _ => failure("501 Not Implemented", "NotImplemented"),
        }
    }

    fn get(&self, request: &Request) -> Answer {
        let found = self.objects.lock().expect("lock").get(&request.key).cloned();
        let Some(Object { bytes, etag }) = found else {
            return failure("404 Not Found", "NoSuchKey");
        };
        if request.headers.get("if-match").is_some_and(|wanted| *wanted != etag) {
            return failure("412 Precondition Failed", "PreconditionFailed");
        }
        let mut headers = vec![
            ("etag", etag),
            ("last-modified", "Fri, 01 May 2026 10:00:00 GMT".to_owned()),
            ("accept-ranges", "bytes".to_owned()),
        ];
        if request.method == "HEAD" {
            let (body, length) = (Vec::new(), Some(bytes.len()));
            return Answer { status: "200 OK", headers, body, length };
        }
        let range = request.headers.get("range").and_then(|r| r.strip_prefix("bytes="));
        let Some((from, to)) = range.and_then(|r| r.split_once('-')) else {
            return Answer { headers, ..fine(bytes.to_vec()) };
        };
        let from: usize = from.parse().expect("start");
        let to = to.parse::<usize>().map_or(bytes.len(), |last| (last + 1).min(bytes.len()));
        if from >= bytes.len() {
            return failure("416 Range Not Satisfiable", "InvalidRange");
        }
        headers.push(("content-range", format!("bytes {from}-{}/{}", to - 1, bytes.len())));
        Answer { status: "206 Partial Content", headers, ..fine(bytes[from..to].to_vec()) }
    }

    fn put_asked(&self, request: &Request) -> Answer {
        let there = self.objects.lock().expect("lock").get(&request.key).map(|o| o.etag.clone());
        let refused = match (request.headers.get("if-none-match"), request.headers.get("if-match"))
        {
            (Some(_), _) => there.is_some(),
            (_, Some(wanted)) => there.as_ref() != Some(wanted),
            _ => false,
        };
        if refused {
            return failure("412 Precondition Failed", "PreconditionFailed");
        }
        let etag = self.put(&request.key, request.body.clone());
        Answer { headers: vec![("etag", etag)], ..fine(Vec::new()) }
    }

    fn delete(&self, body: &[u8]) -> Answer {
        let text = String::from_utf8_lossy(body).into_owned();
        let mut out = "<DeleteResult>".to_owned();
        for part in text.split("<Key>").skip(1) {
            let key = part.split("</Key>").next().unwrap_or("");
            self.objects.lock().expect("lock").remove(&unescaped(key));
            let _ = write!(out, "<Deleted><Key>{key}</Key></Deleted>");
        }
        fine((out + "</DeleteResult>").into_bytes())
    }

    fn list(&self, query: &str) -> Answer {
        let parameters: BTreeMap<&str, String> = query
            .split('&')
            .filter_map(|p| p.split_once('='))
            .map(|(name, value)| (name, decoded(&value.replace('+', " "))))
            .collect();
        let text = |name| parameters.get(name).map_or("", String::as_str);
        let (prefix, after) = (text("prefix"), text("continuation-token"));
        let objects = self.objects.lock().expect("lock");
        let of_prefix = objects.iter().filter(|(key, _)| key.starts_with(prefix));
        let rest: Vec<_> = of_prefix.filter(|(key, _)| key.as_str() > after).collect();
        let page = &rest[..rest.len().min(PAGE)];
        let more = rest.len() > PAGE;
        let mut out = format!("<ListBucketResult><IsTruncated>{more}</IsTruncated>");
        for (key, object) in page {
            let _ = write!(
                out,
                "<Contents><Key>{}</Key><LastModified>2026-05-01T10:00:00.000Z</LastModified>\
                 <ETag>{}</ETag><Size>{}</Size></Contents>",
                escaped(key),
                escaped(&object.etag),
                object.bytes.len()
            );
        }
        if let Some((last, _)) = page.last().filter(|_| more) {
            let _ = write!(out, "<NextContinuationToken>{}</NextContinuationToken>", escaped(last));
        }
        fine((out + "</ListBucketResult>").into_bytes())
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn unescaped(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

fn decoded(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        let code = tail.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        match (first, code.and_then(|hex| u8::from_str_radix(hex, 16).ok())) {
            (b'%', Some(byte)) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

impl Seen {
    /// Bytes of the part that was asked for.
    pub fn length(&self) -> u64 {
        let range = self.range.as_deref().and_then(|r| r.strip_prefix("bytes="));
        let ends = range.and_then(|r| r.split_once('-')).map(|(a, b)| (a.parse(), b.parse()));
        match ends {
            Some((Ok(first), Ok(last))) => {
                let (first, last): (u64, u64) = (first, last);
                last + 1 - first
            }
            _ => u64::MAX, // all of it
        }
    }
}

/// The kinds of fault among requests.
pub fn kinds(seen: &[Seen]) -> BTreeSet<Fault> {
    seen.iter().filter_map(|s| s.fault).collect()
}
