//! The requests of the page about its session: log in, log out, lock. The secret of a session travels in a cookie that no script reads.

use std::time::Duration;

use axum::body::to_bytes;
use axum::extract::{Extension, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use serde::Deserialize;

use super::Shared;
use super::access::{self, Asker};
use super::serve::Near;
use super::sessions::{Key, LoginRefused};
use crate::plant::roles::is_local;
use std::sync::Arc;

/// Bytes of a log-in.
const LONGEST: usize = 1024;
/// The time within which the bytes of a log-in must come.
const WITHIN: Duration = Duration::from_secs(15);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Login {
    user: String,
    password: String,
}

/// The name of the cookie: browsers take `__Host-` from this host over HTTPS only.
fn cookie_name(near: &Near) -> &'static str {
    if near.is_tls { "__Host-arcline" } else { "arcline" }
}

/// The session that a request shows, by its cookie or by a token.
pub(super) fn session_of(shared: &Shared, near: &Near, headers: &HeaderMap) -> Option<Key> {
    match bearer(headers) {
        Some(token) => shared.sessions.of_token(&shared.plant, near.peer(), token),
        None => shared.sessions.of_secret(cookie(headers, cookie_name(near))?),
    }
}

/// The token of a script.
pub(super) fn bearer(headers: &HeaderMap) -> Option<&str> {
    let value = headers.get(header::AUTHORIZATION)?.to_str().ok()?;
    let (scheme, token) = value.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then_some(token.trim())
}

/// The value of a cookie, the first one of its name.
fn cookie<'h>(headers: &'h HeaderMap, name: &str) -> Option<&'h str> {
    let all = headers
        .get_all(header::COOKIE)
        .iter()
        .filter_map(|value| value.to_str().ok());
    let mut pairs = all
        .flat_map(|value| value.split(';'))
        .filter_map(|pair| pair.trim().split_once('='));
    pairs.find(|(of, _)| *of == name).map(|(_, value)| value)
}

/// Whether passwords and cookies may travel on a connection: it is encrypted, or does not leave this computer.
pub(super) fn is_private(near: &Near) -> bool {
    near.is_tls || is_local(near.peer())
}

/// `POST /login`.
pub(super) async fn log_in(
    State(shared): State<Arc<Shared>>,
    Extension(near): Extension<Near>,
    request: Request,
) -> Response {
    let (head, body) = request.into_parts();
    if access::asker(&head.headers) == Asker::Foreign {
        return foreign();
    }
    if !is_private(&near) {
        return (StatusCode::FORBIDDEN, "A password travels over HTTPS only.\n").into_response();
    }
    let body = tokio::time::timeout(WITHIN, to_bytes(body, LONGEST)).await;
    let login = match &body {
        Ok(Ok(body)) => serde_json::from_slice::<Login>(body).ok(),
        Ok(Err(_)) | Err(_) => None,
    };
    let Some(Login { user, password }) = login else {
        return (
            StatusCode::BAD_REQUEST,
            "Expected {\"user\", \"password\"} of at most 1024 bytes.\n",
        )
            .into_response();
    };
    let before = session_of(&shared, &near, &head.headers);
    let sessions = &shared.sessions;
    match sessions
        .log_in(&shared.plant, near.peer(), &user, &password, before.as_ref())
        .await
    {
        Ok(secret) => with_cookie(&near, &secret, ""),
        Err(LoginRefused::Wrong) => (StatusCode::UNAUTHORIZED, "wrong").into_response(),
        Err(LoginRefused::Later(left)) => {
            let seconds = left.as_secs() + 1;
            let headers = [(header::RETRY_AFTER, seconds.to_string())];
            (StatusCode::TOO_MANY_REQUESTS, headers, "later").into_response()
        }
        Err(LoginRefused::NoRandom) => StatusCode::SERVICE_UNAVAILABLE.into_response(),
    }
}

/// `POST /logout`.
pub(super) async fn log_out(
    State(shared): State<Arc<Shared>>,
    Extension(near): Extension<Near>,
    headers: HeaderMap,
) -> Response {
    if access::asker(&headers) != Asker::Own {
        return foreign();
    }
    if let Some(key) = session_of(&shared, &near, &headers) {
        shared.sessions.log_out(&shared.plant, &key);
    }
    with_cookie(&near, "", "; Max-Age=0")
}

/// `POST /lock`.
pub(super) async fn lock(
    State(shared): State<Arc<Shared>>,
    Extension(near): Extension<Near>,
    headers: HeaderMap,
) -> Response {
    if access::asker(&headers) != Asker::Own {
        return foreign();
    }
    match session_of(&shared, &near, &headers) {
        Some(key) => {
            shared.sessions.lock(&shared.plant, &key);
            StatusCode::NO_CONTENT.into_response()
        }
        None => (StatusCode::UNAUTHORIZED, "No user is logged in.\n").into_response(),
    }
}

fn foreign() -> Response {
    (StatusCode::FORBIDDEN, "Only pages of this server may ask for that.\n").into_response()
}

fn with_cookie(near: &Near, secret: &str, more: &str) -> Response {
    let secure = if near.is_tls { "; Secure" } else { "" };
    let cookie = format!(
        "{}={secret}; Path=/; HttpOnly; SameSite=Strict{secure}{more}",
        cookie_name(near)
    );
    let mut response = StatusCode::NO_CONTENT.into_response();
    // Letters and digits always are a header.
    if let Ok(cookie) = HeaderValue::from_str(&cookie) {
        response.headers_mut().insert(header::SET_COOKIE, cookie);
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cookies_and_tokens_are_found() {
        let headers = |pairs: &[(&'static str, &'static str)]| {
            let mut headers = HeaderMap::new();
            for (name, value) in pairs {
                headers.append(*name, HeaderValue::from_static(value));
            }
            headers
        };
        #[rustfmt::skip]
        let cases = [
            ("none",                    headers(&[]),                                              None),
            ("alone",                   headers(&[("cookie", "arcline=abc")]),                     Some("abc")),
            ("among others",            headers(&[("cookie", "a=b; arcline=abc;c=d")]),            Some("abc")),
            ("of another header",       headers(&[("cookie", "a=b"), ("cookie", "arcline=abc")]),  Some("abc")),
            ("the first of two",        headers(&[("cookie", "arcline=abc; arcline=d")]),          Some("abc")),
            ("another name",            headers(&[("cookie", "xarcline=abc; arclinex=d")]),        None),
            ("without a value",         headers(&[("cookie", "arcline")]),                         None),
            ("with an equals sign",     headers(&[("cookie", "arcline=a=b")]),                     Some("a=b")),
        ];
        for (why, headers, expected) in cases {
            assert_eq!(cookie(&headers, "arcline"), expected, "{why}");
        }
        assert_eq!(bearer(&headers(&[("authorization", "Bearer arc_1")])), Some("arc_1"));
        assert_eq!(bearer(&headers(&[("authorization", "bearer  arc_1")])), Some("arc_1"));
        assert_eq!(bearer(&headers(&[("authorization", "Basic YTpi")])), None);
    }
}
