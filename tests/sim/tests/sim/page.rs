//! A browser that shows the page, as far as the server sees it: a WebSocket with requests, answers and pushes.

use std::time::Duration;

use futures_util::{SinkExt as _, StreamExt as _};
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::{WebSocketStream, client_async};

use crate::actors::InTime;
use crate::client::{Answer, NoAnswer, PATIENCE_MS};
use crate::network::End;

/// A page that is open.
pub(crate) struct Page {
    socket: WebSocketStream<End>,
    check: InTime,
    next: u64,
    /// The program that the page shows.
    program: Option<Program>,
}

/// A program that viewers may run, as the page shows it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Program {
    pub(crate) state: String,
    pub(crate) text: String,
}

impl Program {
    /// Whether the program has ended or failed.
    pub(crate) fn is_over(&self) -> bool {
        self.state == "ended" || self.state == "failed"
    }
}

impl Page {
    /// Opens the page on a connection.
    pub(crate) async fn open(end: End, check: InTime) -> Answer<Page> {
        let mut request = format!("ws://{HOST}/ws")
            .into_client_request()
            .map_err(|error| NoAnswer::Wrong(error.to_string()))?;
        let origin = format!("http://{HOST}").parse().expect("a header");
        request.headers_mut().insert("origin", origin);
        let (socket, _) = in_time(async {
            client_async(request, end).await.map_err(|error| match error {
                tokio_tungstenite::tungstenite::Error::Http(answer) => {
                    NoAnswer::Refused(answer.status().as_u16().into())
                }
                _ => NoAnswer::Ended,
            })
        })
        .await?;
        let mut page = Page {
            socket,
            check,
            next: 0,
            program: None,
        };
        in_time(async {
            while page.text().await?["push"] != "hello" {}
            Ok(page)
        })
        .await
    }

    /// Sends a request and waits for its answer: the answer's content, or the sentence of the refusal.
    pub(crate) async fn ask(&mut self, request: Value) -> Answer<Result<Value, String>> {
        let asked = self.check.now();
        let id = self.send(request).await?;
        let answer = in_time(async {
            loop {
                let mut text = self.text().await?;
                if text.get("push").is_some() {
                    continue;
                }
                if text["id"] != id {
                    return Err(NoAnswer::Wrong(format!("it belongs to another request: {text}")));
                }
                return Ok(match text.get_mut("ok") {
                    Some(ok) => Ok(ok.take()),
                    None => Err(text["error"]["text"].as_str().unwrap_or("no text").to_owned()),
                });
            }
        })
        .await?;
        self.check.judge(asked, 0);
        Ok(answer)
    }

    /// Sends a request and does not wait for its answer. Its number.
    pub(crate) async fn send(&mut self, mut request: Value) -> Answer<u64> {
        self.next += 1;
        request["id"] = json!(self.next);
        let sent = self.socket.send(Message::text(request.to_string())).await;
        sent.map(|()| self.next).map_err(|_| NoAnswer::Ended)
    }

    /// The end of a program whose start has been answered, and whose text is no other one's; or another program, which has begun since.
    pub(crate) async fn end_of(&mut self, text: &str) -> Answer<Program> {
        // The state of earlier programs is old.
        self.program.take_if(|program| program.text != text);
        in_time(async {
            loop {
                match &self.program {
                    Some(program) if program.is_over() || program.text != text => return Ok(program.clone()),
                    _ => self.text().await?,
                };
            }
        })
        .await
    }

    /// The next text.
    async fn text(&mut self) -> Answer<Value> {
        loop {
            match self.socket.next().await {
                Some(Ok(Message::Text(text))) => {
                    let text: Value =
                        serde_json::from_str(&text).map_err(|error| NoAnswer::Wrong(error.to_string()))?;
                    if text["push"] == "program" {
                        self.show(&text);
                    }
                    return Ok(text);
                }
                Some(Ok(Message::Close(_)) | Err(_)) | None => return Err(NoAnswer::Ended),
                Some(Ok(_)) => {}
            }
        }
    }

    /// Takes a push of the program: its text comes with the first one of each.
    fn show(&mut self, push: &Value) {
        let program = self.program.get_or_insert_default();
        program.state = push["state"].as_str().unwrap_or_default().to_owned();
        if let Some(text) = push["text"].as_str() {
            program.text = text.to_owned();
        }
    }

    /// The near end of its connection.
    pub(crate) fn end(&self) -> &End {
        self.socket.get_ref()
    }

    /// The same, without the page.
    pub(crate) fn into_end(self) -> End {
        self.socket.into_inner()
    }

    /// Closes the page in order.
    pub(crate) async fn leave(mut self) {
        let _ = self.socket.close(None).await;
    }
}

async fn in_time<T>(answer: impl Future<Output = Answer<T>>) -> Answer<T> {
    tokio::time::timeout(Duration::from_millis(PATIENCE_MS), answer)
        .await
        .unwrap_or(Err(NoAnswer::Late))
}

/// The server, as the page's browser has it in its address line.
const HOST: &str = "10.0.0.1:8080";
