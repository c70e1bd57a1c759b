//! Requests as plain functions: each waits for its answer.
//!
//! `object_store` repeats what fails on its way (see `RETRY` and the crate's `RetryConfig`): no
//! connection, 429, 5xx, a body that breaks off. What it does not repeat, an answer to a listing
//! or a removal that breaks off, is asked again here, for a minute at most; each of these does the
//! same when it is done twice.

use std::collections::HashMap;
use std::future::Future;
use std::io::{Error, ErrorKind, Result};
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use bytes::Bytes;
use futures::{StreamExt, TryStreamExt};
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::azure::MicrosoftAzureBuilder;
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::path::Path as Key;
use object_store::{
    BackoffConfig, GetOptions, GetRange, ObjectMeta, ObjectStore, ObjectStoreExt, PutMode,
    PutOptions, RetryConfig, UpdateVersion,
};
use tokio::runtime::{Builder, Runtime};

use super::arrival;
use super::connector::Counting;
use super::counts::{Counter, add};
use super::errors;
use super::stat::{Entry, Stat};
use super::url::{Scheme, Url};

/// How one request is repeated: up to ten times within three minutes, after 0.1 s, 0.2 s, ... at
/// most 15 s, with some chance in it. An answer that takes longer than 30 s counts as failed (the
/// crate's own limit; `AWS_TIMEOUT` sets another).
const RETRY: RetryConfig = RetryConfig {
    backoff: BackoffConfig {
        init_backoff: Duration::from_millis(100),
        max_backoff: Duration::from_secs(15),
        base: 2.0,
    },
    max_retries: 10,
    retry_timeout: Duration::from_secs(180),
};

/// How long a whole operation is begun anew.
const AGAIN: Duration = Duration::from_secs(60);

/// Requests under way at once where many objects are asked for together.
const TOGETHER: usize = 16;

/// How often bytes may be lost on the way.
const TRIES: usize = 6;
/// Largest object that is fetched as a whole where it cannot be trusted in parts, bytes.
const WHOLE: u64 = 64 << 20;
/// Ranges nearer to each other than this are asked for as one.
const GAP: u64 = 256 << 10;

/// Threads of the network: they only move bytes.
const THREADS: usize = 2;

type Client = Arc<dyn ObjectStore>;

fn runtime() -> Result<&'static Runtime> {
    static RUNTIME: OnceLock<std::result::Result<Runtime, String>> = OnceLock::new();
    let made = RUNTIME.get_or_init(|| {
        let build = || {
            Builder::new_multi_thread()
                .worker_threads(THREADS)
                .thread_name("roadbench-objects")
                .enable_all()
                .build()
        };
        can_start(1 + THREADS).and_then(|()| build()).map_err(|e| e.to_string())
    });
    made.as_ref().map_err(|e| Error::other(format!("cannot start the network threads: {e}")))
}

/// Whether so many threads can be started: a runtime that cannot start its own panics.
fn can_start(threads: usize) -> Result<()> {
    let gate = Mutex::new(());
    std::thread::scope(|scope| {
        let shut = gate.lock().unwrap_or_else(PoisonError::into_inner);
        // each waits for the last
        let wait = || drop(gate.lock());
        let mut all = (0..threads).map(|_| std::thread::Builder::new().spawn_scoped(scope, wait));
        let started = all.try_for_each(|thread| thread.map(|_| ()));
        drop(shut);
        started
    })
}

/// The bucket's client; made once.
fn client(url: &Url) -> Result<Client> {
    type Clients = HashMap<(Scheme, String), Client>;
    static CLIENTS: OnceLock<Mutex<Clients>> = OnceLock::new();
    let clients = CLIENTS.get_or_init(Mutex::default);
    let mut clients = clients.lock().unwrap_or_else(PoisonError::into_inner);
    let bucket = (url.scheme, url.bucket.clone());
    if let Some(known) = clients.get(&bucket) {
        return Ok(Arc::clone(known));
    }
    let made = connect(url)?;
    clients.insert(bucket, Arc::clone(&made));
    Ok(made)
}

fn connect(url: &Url) -> Result<Client> {
    let bucket = url.bucket.as_str();
    let made: object_store::Result<Client> = match url.scheme {
        Scheme::S3 => {
            let builder = AmazonS3Builder::from_env().with_bucket_name(bucket);
            errors::credentials_at_hand(&|key: AmazonS3ConfigKey| builder.get_config_value(&key))?;
            builder
                .with_retry(RETRY)
                .with_http_connector(Counting)
                .build()
                .map(|c| Arc::new(c) as Client)
        }
        Scheme::Gs => GoogleCloudStorageBuilder::from_env()
            .with_bucket_name(bucket)
            .with_retry(RETRY)
            .with_http_connector(Counting)
            .build()
            .map(|c| Arc::new(c) as Client),
        Scheme::Az => MicrosoftAzureBuilder::from_env()
            .with_container_name(bucket)
            .with_retry(RETRY)
            .with_http_connector(Counting)
            .build()
            .map(|c| Arc::new(c) as Client),
    };
    made.map_err(|e| errors::explain(url, e))
}

fn key(url: &Url) -> Result<Key> {
    Key::parse(&url.key)
        .map_err(|e| Error::new(ErrorKind::InvalidInput, format!("{url}: not a key: {e}")))
}

/// Does it, and again where it failed without a reason that would stay.
fn again<T, F>(url: &Url, what: impl Fn(Client, Key) -> F) -> Result<T>
where
    F: Future<Output = object_store::Result<T>>,
{
    let (runtime, client, key) = (runtime()?, client(url)?, key(url)?);
    let begun = Instant::now();
    let mut pause = Duration::from_millis(100);
    runtime.block_on(async {
        loop {
            let error = match what(Arc::clone(&client), key.clone()).await {
                Ok(done) => return Ok(done),
                Err(error) => error,
            };
            if !errors::is_transient(&error) || begun.elapsed() > AGAIN {
                return Err(errors::explain(url, error));
            }
            add(Counter::Failed, 1);
            tracing::debug!("{url}: asking again: {error}");
            tokio::time::sleep(pause).await;
            pause = (pause * 2).min(Duration::from_secs(5));
        }
    })
}

fn stat_of(meta: &ObjectMeta) -> Stat {
    Stat {
        size: meta.size,
        etag: meta.e_tag.as_ref().map(|e| e.trim_matches('"').to_owned()),
        modified: SystemTime::from(meta.last_modified),
    }
}

/// Known properties of one object.
///
/// # Errors
/// It is not there (`NotFound`), or the store does not answer.
pub(crate) fn stat(url: &Url) -> Result<Stat> {
    let meta = again(url, |client, key| async move { client.head(&key).await })?;
    Ok(stat_of(&meta))
}

/// Every object below a prefix, in order of key.
///
/// # Errors
/// The bucket is not there, or the store does not answer.
pub(crate) fn list(prefix: &Url) -> Result<Vec<Entry>> {
    let metas: Vec<ObjectMeta> = again(prefix, |client, key| async move {
        let below = (!key.as_ref().is_empty()).then_some(&key);
        client.list(below).try_collect().await
    })?;
    let skip = if prefix.key.is_empty() { 0 } else { prefix.key.len() + 1 };
    let mut entries: Vec<Entry> = metas
        .iter()
        .filter_map(|meta| {
            let key = meta.location.as_ref().get(skip..).filter(|k| !k.is_empty())?;
            Some(Entry { key: key.to_owned(), stat: stat_of(meta) })
        })
        .collect();
    entries.sort_by(|a, b| a.key.cmp(&b.key));
    Ok(entries)
}

/// A whole object.
///
/// # Errors
/// It is not there (`NotFound`), or the store does not give it.
pub(crate) fn get(url: &Url) -> Result<Bytes> {
    get_version(url, None)
}

/// A whole object, where it is given only of the bytes that `etag` names.
///
/// # Errors
/// As [`get`]; or it was written anew since.
pub(crate) fn get_version(url: &Url, etag: Option<&str>) -> Result<Bytes> {
    let wanted = etag.map(|e| format!("\"{e}\""));
    let mut before: Option<Bytes> = None;
    for _ in 0..TRIES {
        let (etag, bytes) = again(url, |client, key| {
            let options = GetOptions::default().with_if_match(wanted.clone());
            async move {
                let got = client.get_opts(&key, options).await?;
                Ok((got.meta.e_tag.clone(), got.bytes().await?))
            }
        })?;
        add(Counter::Read, bytes.len() as u64);
        if !arrival::differs(etag.as_deref(), &bytes) {
            return Ok(bytes);
        }
        if before.as_ref() == Some(&bytes) {
            arrival::names_are_others(); // the same twice: that was no accident
            return Ok(bytes);
        }
        tracing::warn!("{url}: the received bytes do not match the checksum; asking again");
        before = Some(bytes);
    }
    Err(never_whole(url))
}

fn never_whole(url: &Url) -> Error {
    Error::other(format!(
        "{url}: the received bytes do not match the checksum, {TRIES} times in a row; check the \
         network, or use https"
    ))
}

/// Many whole objects, a few at a time, in their order.
///
/// # Errors
/// Each may be one, as [`get`]'s.
pub(crate) fn get_many(urls: &[Url]) -> Vec<Result<Bytes>> {
    if urls.is_empty() {
        return Vec::new(); // local files need no network
    }
    let all = || -> Result<Vec<Result<Bytes>>> {
        let runtime = runtime()?;
        let requests = urls
            .iter()
            .map(|url| Ok((client(url)?, key(url)?)))
            .collect::<Result<Vec<(Client, Key)>>>()?;
        let requests = requests.into_iter().map(|(client, key)| async move {
            let got = client.get(&key).await?;
            Ok((got.meta.e_tag.clone(), got.bytes().await?))
        });
        let answers: Vec<object_store::Result<(Option<String>, Bytes)>> =
            runtime.block_on(futures::stream::iter(requests).buffered(TOGETHER).collect());
        let answers = answers.into_iter().zip(urls);
        Ok(answers
            .map(|(answer, url)| match answer {
                Ok((etag, bytes)) if arrival::differs(etag.as_deref(), &bytes) => get(url),
                Ok((_, bytes)) => {
                    add(Counter::Read, bytes.len() as u64);
                    Ok(bytes)
                }
                Err(e) if errors::is_transient(&e) => get(url),
                Err(e) => Err(errors::explain(url, e)),
            })
            .collect())
    };
    all()
        .unwrap_or_else(|e| urls.iter().map(|_| Err(Error::new(e.kind(), e.to_string()))).collect())
}

/// Whether an object is better fetched as a whole, so that the bytes can be checked against its name.
pub(crate) fn should_be_whole(stat: &Stat) -> bool {
    stat.size <= WHOLE
        && stat.etag.as_deref().is_some_and(arrival::is_checksum)
        && arrival::is_plain()
}

/// Parts of an object, all from the same bytes: of those that `etag` names, where it is given.
/// Neighbouring ranges are asked for as one.
///
/// # Errors
/// As [`get`]; or it was written anew since.
pub(crate) fn get_ranges(
    url: &Url,
    etag: Option<&str>,
    ranges: &[Range<u64>],
) -> Result<Vec<(u64, Bytes)>> {
    let merged = merge(ranges);
    let etag = etag.map(|e| format!("\"{e}\""));
    let parts: Vec<Bytes> = again(url, |client, key| {
        let (merged, etag) = (merged.clone(), etag.clone());
        async move {
            let requests = merged.into_iter().map(|range| {
                let options = GetOptions::default()
                    .with_range(Some(GetRange::Bounded(range)))
                    .with_if_match(etag.clone());
                let (client, key) = (&client, &key);
                async move { client.get_opts(key, options).await?.bytes().await }
            });
            futures::stream::iter(requests).buffered(TOGETHER).try_collect().await
        }
    })?;
    for (part, range) in parts.iter().zip(&merged) {
        add(Counter::Read, part.len() as u64);
        if part.len() as u64 != range.end - range.start {
            let what = format!("{url}: received {} bytes instead of {range:?}", part.len());
            return Err(Error::new(ErrorKind::UnexpectedEof, what));
        }
    }
    Ok(merged.iter().map(|r| r.start).zip(parts).collect())
}

fn merge(ranges: &[Range<u64>]) -> Vec<Range<u64>> {
    let mut sorted: Vec<Range<u64>> = ranges.iter().filter(|r| r.start < r.end).cloned().collect();
    sorted.sort_by_key(|r| r.start);
    let mut merged: Vec<Range<u64>> = Vec::new();
    for range in sorted {
        match merged.last_mut() {
            Some(last) if range.start <= last.end.saturating_add(GAP) => {
                last.end = last.end.max(range.end);
            }
            _ => merged.push(range),
        }
    }
    merged
}

/// Writes an object, whole or not at all.
///
/// # Errors
/// The store does not take it.
pub(crate) fn put(url: &Url, bytes: &[u8]) -> Result<()> {
    let bytes = Bytes::copy_from_slice(bytes);
    for _ in 0..TRIES {
        let done = again(url, |client, key| {
            let bytes = bytes.clone();
            async move { client.put(&key, bytes.into()).await }
        })?;
        add(Counter::Written, bytes.len() as u64);
        // one whose name is no checksum is looked at once
        if !arrival::differs(done.e_tag.as_deref(), &bytes) || get(url)? == bytes {
            return Ok(());
        }
        tracing::warn!("{url}: the stored bytes do not match the checksum; sending it again");
    }
    Err(never_whole(url))
}

/// Writes an object where there is none, or in place of the very bytes that `over` names; gives
/// back its etag.
///
/// # Errors
/// `AlreadyExists`: there is one, or another one than `over`. The request may have been repeated
/// after its answer was lost: the object that is there can be this one.
pub(crate) fn put_if(url: &Url, bytes: &[u8], over: Option<&str>) -> Result<Option<String>> {
    let bytes = Bytes::copy_from_slice(bytes);
    let done = again(url, |client, key| {
        let bytes = bytes.clone();
        let mode = match over {
            None => PutMode::Create,
            Some(etag) => {
                PutMode::Update(UpdateVersion { e_tag: Some(format!("\"{etag}\"")), version: None })
            }
        };
        async move { client.put_opts(&key, bytes.into(), PutOptions::from(mode)).await }
    })?;
    add(Counter::Written, bytes.len() as u64);
    Ok(done.e_tag.map(|e| e.trim_matches('"').to_owned()))
}

/// Removes an object; that there is none is no error.
///
/// # Errors
/// The store does not remove it.
pub(crate) fn delete(url: &Url) -> Result<()> {
    match again(url, |client, key| async move { client.delete(&key).await }) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(()),
        done => done,
    }
}

/// Removes many objects, a few at a time.
///
/// # Errors
/// As [`delete`]; the others may be gone.
pub(crate) fn delete_many(urls: &[Url]) -> Result<()> {
    if urls.is_empty() {
        return Ok(());
    }
    let runtime = runtime()?;
    let requests =
        urls.iter().map(|url| Ok((client(url)?, key(url)?))).collect::<Result<Vec<_>>>()?;
    let requests = requests
        .into_iter()
        .map(|(client, key): (Client, Key)| async move { client.delete(&key).await.is_ok() });
    let done: Vec<bool> =
        runtime.block_on(futures::stream::iter(requests).buffered(TOGETHER).collect());
    // what did not go at once is asked for again, or says why
    urls.iter().zip(done).filter(|(_, done)| !done).try_for_each(|(url, _)| delete(url))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_ranges_become_one() {
        let merged = merge(&[10..20, 0..4, 15..30, 5..5]);
        assert_eq!((merged.len(), merged[0].clone()), (1, 0..30));
        let far = GAP + 31;
        assert_eq!(merge(&[far..far + 5, 0..30]), [0..30, far..far + 5]);
        assert_eq!(merge(&[]), Vec::<Range<u64>>::new());
    }
}
