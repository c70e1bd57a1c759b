//! The HTTP client as `object_store` makes it, with a count of what goes through.

use std::future::Future;
use std::pin::Pin;

use object_store::ClientOptions;
use object_store::client::{
    HttpClient, HttpConnector, HttpError, HttpRequest, HttpResponse, HttpService, ReqwestConnector,
};

use super::counts::{Counter, add};

/// Makes clients that count.
#[derive(Debug, Default)]
pub(super) struct Counting;

impl HttpConnector for Counting {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        let client = ReqwestConnector::default().connect(options)?;
        Ok(HttpClient::new(Counted(client)))
    }
}

#[derive(Debug)]
struct Counted(HttpClient);

/// Kind of a request. A listing is a GET like others, but for its query.
fn kind(method: &str, query: &str) -> Counter {
    let lists = ["list-type=", "comp=list", "prefix=", "max-keys=", "maxResults="];
    match method {
        "GET" if lists.iter().any(|l| query.contains(l)) => Counter::List,
        "GET" => Counter::Get,
        "HEAD" => Counter::Head,
        "PUT" => Counter::Put,
        "DELETE" => Counter::Delete,
        "POST" if query.split('&').any(|q| q == "delete" || q == "delete=") => Counter::Delete,
        _ => Counter::Other,
    }
}

type Answer<'a> = Pin<Box<dyn Future<Output = Result<HttpResponse, HttpError>> + Send + 'a>>;

impl HttpService for Counted {
    // written out: the trait's macro is not a dependency of ours
    fn call<'a, 'b>(&'a self, request: HttpRequest) -> Answer<'b>
    where
        'a: 'b,
        Self: 'b,
    {
        add(kind(request.method().as_str(), request.uri().query().unwrap_or("")), 1);
        Box::pin(async move {
            let answer = self.0.execute(request).await;
            let failed = match &answer {
                Ok(response) => {
                    let status = response.status().as_u16();
                    status >= 500 || status == 429 || status == 408
                }
                Err(_) => true,
            };
            if failed {
                add(Counter::Failed, 1);
            }
            answer
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_told_apart() {
        for (method, query, wanted) in [
            ("GET", "", "Get"),
            ("GET", "list-type=2&prefix=a", "List"),
            ("GET", "comp=list&restype=container", "List"),
            ("POST", "delete", "Delete"),
            ("POST", "uploads", "Other"),
            ("HEAD", "", "Head"),
        ] {
            assert_eq!(format!("{:?}", kind(method, query)), wanted, "{method} {query}");
        }
    }
}
