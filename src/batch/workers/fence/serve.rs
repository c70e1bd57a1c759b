//! The worker: answers questions about logs, one at a time, until nobody asks any more.

use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::mpsc::channel;

use serde::Serialize;

use super::sandbox;
use super::wire::{self, Answer, File, Question, Request, Response, Setup};
use crate::batch::jobs::bikes::BikeFile;
use crate::batch::jobs::distributed::{diagnose_work, run_work};
use crate::batch::jobs::job_kind::JobKind;
use crate::batch::jobs::work::{Work, guarded};
use crate::batch::settings::Maps;
use crate::batch::workers::threads::STACK;
use crate::contract::bike::Bike;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::pipeline::{Input, Pipeline, Rejection};
use crate::store::objects::counts;

/// Longest question, bytes of its body: it has none.
const NO_BODY: u64 = 0;

/// Serves the process at the other end of standard input and output, and ends with it; gives back the exit code.
pub(crate) fn serve() -> u8 {
    match work() {
        Ok(()) => 0,
        Err(e) => {
            let _ = writeln!(io::stderr(), "{e}");
            1
        }
    }
}

fn work() -> Result<(), String> {
    let text = |e: io::Error| e.to_string();
    let (setup, _): (Setup, _) = wire::receive(&mut io::stdin(), NO_BODY).map_err(text)?;
    // before there are threads: each takes its rights from the one that starts it
    sandbox::enter(setup.offline);
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK);
        let serving = thread.spawn_scoped(scope, || ready(setup)).map_err(text)?;
        serving.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Gets ready and answers, all in this thread.
fn ready(setup: Setup) -> Result<(), String> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
    one.map_err(|e| e.to_string())?;
    let pipeline = Pipeline::parse(&setup.pipeline, "pipeline")?;
    let maps = Maps::parse(&setup.maps)?;
    match setup.what {
        JobKind::Run { signals } => answers(&run_work(signals), &pipeline, &maps),
        JobKind::Diagnose { nulls, advise } => {
            let work = diagnose_work(nulls, advise).map_err(|e| e.to_string())?;
            answers(&work, &pipeline, &maps)
        }
    }
}

fn answers<W: Work<Result: Serialize>>(
    work: &W,
    pipeline: &Pipeline,
    maps: &Maps,
) -> Result<(), String> {
    let (sender, questions) = channel();
    let listen = move || {
        while let Ok((asked, _)) = wire::receive::<Request<Question>>(&mut io::stdin(), NO_BODY) {
            if sender.send(asked).is_err() {
                break;
            }
        }
        // the process that asks is gone: what is under way is for nobody
        std::process::exit(0);
    };
    std::thread::Builder::new().spawn(listen).map_err(|e| e.to_string())?;
    let mut to = BufWriter::new(io::stdout());
    let ready = Answer::Ready { version: crate::VERSION.to_owned(), may: sandbox::rights() };
    let ready = Response { answer: ready, requests: counts::so_far() };
    wire::send(&mut to, &ready, &[]).map_err(|e| e.to_string())?;
    for Request { memory, question } in questions {
        sandbox::limit_memory(memory);
        let before = counts::so_far();
        let (answer, bodies) = answer(work, pipeline, maps, question);
        let answer = Response { answer, requests: counts::since(before) };
        let bodies: Vec<&[u8]> = bodies.iter().map(Vec::as_slice).collect();
        wire::send(&mut to, &answer, &bodies).map_err(|e| e.to_string())?;
    }
    Ok(())
}

/// The answer, and the files that go with it.
fn answer<W: Work<Result: Serialize>>(
    work: &W,
    pipeline: &Pipeline,
    maps: &Maps,
    question: Question,
) -> (Answer, Vec<Vec<u8>>) {
    let done = match question {
        Question::Identify { log } => {
            let log = log.location();
            guarded(Stage::Ingest, || work.identify(&log, maps.list()))
                .map(|who| (Answer::Identified(who), Vec::new()))
        }
        Question::Run { log, input_hash, pipeline_hash, bike_id, bike, signals, result } => {
            let maps = maps.list();
            let input = Input { log: log.location(), maps, input_hash, pipeline_hash, signals };
            guarded(work.kind().stage, || session(work, pipeline, &input, (&bike_id, bike), result))
        }
    };
    done.unwrap_or_else(|why| {
        let Rejection { stage, code, message, .. } = why;
        (Answer::Rejected { stage, code, message }, Vec::new())
    })
}

fn session<W: Work<Result: Serialize>>(
    work: &W,
    pipeline: &Pipeline,
    input: &Input<'_>,
    (bike_id, bike): (&str, String),
    wants_result: bool,
) -> Result<(Answer, Vec<Vec<u8>>), Rejection> {
    let own = |message: String| Rejection {
        stage: work.kind().stage,
        code: RejectionCode::InternalError,
        message,
        limits: None,
    };
    let parsed = Bike::parse(&bike, bike_id, Path::new(bike_id)).map_err(|e| own(e.to_string()))?;
    let bike =
        BikeFile { bike: parsed, text: bike, pipeline_hash: String::new() /* nobody asks */ };
    let output = work.run(input, &bike, pipeline)?;
    let result = match output.result.filter(|_| wants_result) {
        Some(result) => serde_json::to_vec(&result).map_err(|e| own(e.to_string()))?,
        None => Vec::new(),
    };
    let file = |f: &crate::batch::jobs::work::SessionFile| File {
        folder: f.folder.to_owned(),
        extension: f.extension.to_owned(),
        bytes: f.bytes.len() as u64,
    };
    let files = output.files.iter().map(file).collect();
    let (ident, samples) = (output.ident, output.samples);
    let answer = Answer::Done { ident, samples, files, result: result.len() as u64 };
    let bodies = output.files.into_iter().map(|f| f.bytes).chain([result]);
    Ok((answer, bodies.collect()))
}
