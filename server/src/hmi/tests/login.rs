//! Users, sessions, tokens, and the page over HTTPS.

use std::fs;

use arcline_config::Role;
use tokio_tungstenite::client_async;

use super::secured::{ANNA, BERT, Secured, TOKEN, post};
use super::*;
use crate::users::password;

async fn role_of(viewer: &mut Viewer) -> (Value, Value, bool) {
    let mut session = viewer.push("session").await;
    let locked = session["locked"].as_bool().expect("a boolean");
    (session["role"].take(), session["user"].take(), locked)
}

/// Writes a tag, which a role below operator may not do; returns whether the server accepts it.
async fn writes(viewer: &mut Viewer) -> bool {
    let answer = viewer
        .ask(json!({"do": "write", "tag": "Move1.Speed", "value": 5}))
        .await;
    answer.is_ok()
}

async fn speed(viewer: &mut Viewer) -> f64 {
    let read = viewer
        .ask(json!({"do": "read", "names": ["Move1.Speed"]}))
        .await
        .expect("a viewer may look");
    read["values"]["Move1.Speed"].as_f64().expect("a number")
}

/// Waits until the server closes; returns its code.
async fn closed(viewer: &mut Viewer) -> Option<u16> {
    loop {
        match timeout(SOON, viewer.socket.next()).await.expect("in time") {
            Some(Ok(Message::Close(frame))) => return frame.map(|frame| frame.code.into()),
            Some(Ok(_)) => {}
            Some(Err(_)) | None => return None,
        }
    }
}

#[tokio::test]
async fn a_login_raises_the_role_and_a_logout_closes_the_socket() {
    let page = Secured::start().await;
    let origin = format!("http://{}", page.bench.address);
    let mut nobody = page.viewer(&[("origin", &origin)]).await;
    assert_eq!(role_of(&mut nobody).await, (json!("viewer"), Value::Null, false));
    assert!(!writes(&mut nobody).await, "nobody has logged in");
    let cookie = page.log_in("anna", ANNA).await.expect("it is her password");
    let mut anna = page.page(&cookie).await;
    assert_eq!(role_of(&mut anna).await, (json!("operator"), json!("anna"), false));
    assert!(writes(&mut anna).await);
    let answer = page.post_with("/logout", &cookie).await;
    assert!(
        answer.starts_with("HTTP/1.1 204") && answer.contains("Max-Age=0"),
        "{answer}"
    );
    assert_eq!(closed(&mut anna).await, Some(4401));
    let mut again = page.page(&cookie).await;
    assert_eq!(role_of(&mut again).await.0, "viewer", "the session is over");
}

#[tokio::test]
async fn answers_to_a_login_do_not_name_the_wrong_part() {
    let page = Secured::start().await;
    let mut answers = Vec::new();
    for (user, password) in [("anna", "wrong"), ("nobody at all", ANNA), ("anna", BERT)] {
        let body = json!({"user": user, "password": password}).to_string();
        let answer = page.post("/login", "", &body).await;
        assert!(
            answer.starts_with("HTTP/1.1 401") && answer.ends_with("\r\n\r\nwrong"),
            "{answer}"
        );
        answers.push(
            answer
                .lines()
                .filter(|line| !line.starts_with("date"))
                .collect::<Vec<_>>()
                .join("\n"),
        );
    }
    answers.dedup();
    assert_eq!(answers.len(), 1, "{answers:?}");
    let good = json!({"user": "anna", "password": ANNA}).to_string();
    let answer = page.post("/login", "", &good).await;
    assert!(answer.contains("cache-control: no-store"), "{answer}");
    assert!(
        answer.contains("; Path=/; HttpOnly; SameSite=Strict\r\n") && answer.contains("set-cookie: arcline="),
        "{answer}"
    );
    #[rustfmt::skip]
    let cases = [
        ("another site",   "Sec-Fetch-Site: cross-site\r\n".to_owned(), good.clone(),                                       "403"),
        ("its origin",     "Origin: http://evil.example\r\n".to_owned(), good.clone(),                                      "403"),
        ("a sandbox",      "Origin: null\r\n".to_owned(),                good.clone(),                                      "403"),
        ("no JSON",        String::new(),                                "user=anna".to_owned(),                            "400"),
        ("another key",    String::new(),                                json!({"user": "anna", "password": ANNA, "role": "administrator"}).to_string(), "400"),
        ("too long",       String::new(),                                json!({"user": "anna", "password": "x".repeat(2_000)}).to_string(), "400"),
    ];
    for (why, headers, body, status) in cases {
        let answer = page.post("/login", &headers, &body).await;
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{why}: {answer}");
        assert!(!answer.contains("set-cookie"), "{why}: {answer}");
    }
    for path in ["/logout", "/lock"] {
        let answer = page.post(path, "Origin: http://evil.example\r\n", "").await;
        assert!(answer.starts_with("HTTP/1.1 403"), "{path}: {answer}");
        let answer = page.post(path, "", "").await;
        assert!(answer.starts_with("HTTP/1.1 403"), "no page, {path}: {answer}");
    }
}

#[tokio::test]
async fn the_sixth_failure_is_refused_for_a_while() {
    let page = Secured::start().await;
    for number in 1..=5 {
        let answer = page.log_in("anna", "wrong").await.expect_err("it is wrong");
        assert!(answer.starts_with("HTTP/1.1 401"), "{number}: {answer}");
    }
    let answer = page.log_in("anna", ANNA).await.expect_err("it is locked");
    assert!(
        answer.starts_with("HTTP/1.1 429") && answer.contains("retry-after: "),
        "{answer}"
    );
    // From this computer, the lockout lasts a second at most.
    let again = async { while page.log_in("anna", ANNA).await.is_err() {} };
    timeout(SOON, again).await.expect("in time");
}

#[tokio::test]
async fn a_locked_page_looks_and_stops() {
    let page = Secured::start().await;
    let cookie = page.log_in("bert", BERT).await.expect("it is his password");
    let mut bert = page.page(&cookie).await;
    assert_eq!(role_of(&mut bert).await, (json!("administrator"), json!("bert"), false));
    let counts = "WHILE TRUE DO Move1.Speed := Move1.Speed + 1; DELAY(0.005); END_WHILE;";
    bert.run(counts).await.expect("it runs");
    bert.program("running").await;
    let answer = page.post_with("/lock", &cookie).await;
    assert!(answer.starts_with("HTTP/1.1 204"), "{answer}");
    assert_eq!(role_of(&mut bert).await, (json!("viewer"), json!("bert"), true));
    assert!(!writes(&mut bert).await, "it is locked");
    let began = speed(&mut bert).await;
    while speed(&mut bert).await < began + 5.0 {}
    assert_eq!(bert.ask(json!({"do": "stop"})).await, Ok(json!({})));
    bert.program("ended").await;
    let refused = bert.ask(json!({"do": "release_stop"})).await.expect_err("it is locked");
    assert!(
        refused["text"]
            .as_str()
            .is_some_and(|text| text.starts_with("the role viewer may not")),
        "{refused}"
    );
    // The password opens it again, as another session: the one before is over.
    let body = json!({"user": "bert", "password": BERT}).to_string();
    let answer = page.post("/login", &format!("Cookie: {cookie}\r\n"), &body).await;
    assert!(answer.starts_with("HTTP/1.1 204"), "{answer}");
    assert_eq!(closed(&mut bert).await, Some(4401));
}

#[tokio::test]
async fn a_session_without_a_person_is_locked_and_ends() {
    let page = Secured::start().await;
    let cookie = page.log_in("anna", ANNA).await.expect("it is her password");
    let mut anna = page.page(&cookie).await;
    role_of(&mut anna).await;
    let now = tokio::time::Instant::now();
    page.sessions.judge(&page.bench.plant, now + Duration::from_secs(1_700));
    assert!(writes(&mut anna).await, "not yet");
    page.sessions.judge(&page.bench.plant, now + Duration::from_secs(1_900));
    assert_eq!(role_of(&mut anna).await, (json!("viewer"), json!("anna"), true));
    assert_eq!(anna.ask(json!({"do": "active"})).await, Ok(json!({})));
    assert!(!writes(&mut anna).await, "input opens no lock");
    page.sessions
        .judge(&page.bench.plant, now + Duration::from_secs(43_300));
    assert_eq!(closed(&mut anna).await, Some(4401));
}

/// A change that an administrator makes in the file takes effect within about a second, for open sockets too.
#[tokio::test]
async fn a_change_of_the_users_reaches_open_sessions() {
    let page = Secured::start().await;
    let audit = page.folder.path().join("audit");
    let opened = crate::audit::Audit::open(&audit).expect("a writable folder");
    page.bench.plant.set_audit(opened);
    let (anna, bert) = (page.log_in("anna", ANNA).await, page.log_in("bert", BERT).await);
    let mut anna = page.page(&anna.expect("it is her password")).await;
    let mut bert = page.page(&bert.expect("it is his password")).await;
    role_of(&mut anna).await;
    role_of(&mut bert).await;
    page.change(|users| users.users[0].role = Role::Engineer);
    assert_eq!(role_of(&mut anna).await, (json!("engineer"), json!("anna"), false));
    page.change(|users| users.users[0].is_disabled = true);
    assert_eq!(closed(&mut anna).await, Some(4401));
    let answer = page.log_in("anna", ANNA).await.expect_err("disabled");
    assert!(answer.starts_with("HTTP/1.1 401"), "{answer}");
    page.change(|users| users.users[1].logouts += 1);
    assert_eq!(closed(&mut bert).await, Some(4401));
    let again = page.log_in("bert", BERT).await.expect("he can log in again");
    let mut bert = page.page(&again).await;
    role_of(&mut bert).await;
    page.change(|users| users.users[1].password = password::hash("another long password").expect("it is hashed"));
    assert_eq!(closed(&mut bert).await, Some(4401));
    // A file that is of no use changes nothing.
    fs::write(page.folder.path().join("users.toml"), "nonsense = = 1").expect("a writable folder");
    assert!(page.log_in("bert", "another long password").await.is_ok());
    // The audit has each time that the file was read.
    let reloads = || {
        let text = fs::read_to_string(audit.join("000001.jsonl")).expect("it is there");
        let lines = text
            .lines()
            .filter(|line| line.contains("\"what\":\"reload\",\"object\":\"the users of the page\""));
        lines
            .map(|line| line.contains("\"result\":\"done\""))
            .collect::<Vec<_>>()
    };
    let began = std::time::Instant::now();
    while reloads() != [true, true, true, true, false] {
        assert!(began.elapsed() < SOON, "{:?}", reloads());
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
}

/// Every role below administrator is refused, an administrator sees every session and ends one; the ended session learns why.
#[tokio::test]
async fn an_administrator_sees_and_ends_sessions() {
    let page = Secured::start().await;
    let audit = page.folder.path().join("audit");
    let opened = crate::audit::Audit::open(&audit).expect("a writable folder");
    page.bench.plant.set_audit(opened);
    let cookie = page.log_in("anna", ANNA).await.expect("it is her password");
    let (mut anna, mut second) = (page.page(&cookie).await, page.page(&cookie).await);
    role_of(&mut anna).await;
    for role in [Role::Operator, Role::Viewer, Role::Engineer] {
        if role != Role::Operator {
            page.change(|users| users.users[0].role = role);
            assert_eq!(role_of(&mut anna).await.0, json!(role.word()));
        }
        for request in [json!({"do": "sessions"}), json!({"do": "end_session", "session": 1})] {
            let refused = anna.ask(request).await.expect_err("she is no administrator");
            let text = refused["text"].as_str().unwrap_or_default();
            let expected = format!("the role {} may not end sessions", role.word());
            assert!(text.starts_with(&expected), "{refused}");
        }
    }
    let bearer = format!("Bearer {TOKEN}");
    let mut script = page.viewer(&[("authorization", &bearer)]).await;
    role_of(&mut script).await;
    let bert = page.log_in("bert", BERT).await.expect("it is his password");
    let mut bert = page.page(&bert).await;
    role_of(&mut bert).await;
    let list = bert.ask(json!({"do": "sessions"})).await.expect("an administrator may");
    let rows = list["sessions"].as_array().expect("a list");
    let told = |row: &Value| {
        ["session", "user", "script", "role", "locked", "address", "pages", "own"].map(|key| row[key].clone())
    };
    let told: Vec<_> = rows.iter().map(told).collect();
    #[rustfmt::skip]
    let expected = [
        [json!(1), json!("anna"),   json!(false), json!("engineer"),      json!(false), json!("127.0.0.1"), json!(2), json!(false)],
        [json!(2), json!("logger"), json!(true),  json!("operator"),      json!(false), json!("127.0.0.1"), json!(1), json!(false)],
        [json!(3), json!("bert"),   json!(false), json!("administrator"), json!(false), json!("127.0.0.1"), json!(1), json!(true)],
    ];
    assert_eq!(told, expected, "{list}");
    assert!(
        !list.to_string().contains(&crate::audit::sha256(TOKEN)),
        "no secret and no hash of one"
    );
    let none = bert.ask(json!({"do": "end_session", "session": 9})).await;
    assert_eq!(none, Err(json!({"text": "there is no session 9: it may have ended"})));
    assert_eq!(
        bert.ask(json!({"do": "end_session", "session": 1})).await,
        Ok(json!({}))
    );
    let why = "the session has ended: an administrator ended it";
    for viewer in [&mut anna, &mut second] {
        assert_eq!(next_answer(viewer).await, why);
    }
    // The server no longer knows the cookie.
    let answer = page.post_with("/lock", &cookie).await;
    assert!(
        answer.starts_with("HTTP/1.1 401") && answer.ends_with("No user is logged in.\n"),
        "{answer}"
    );
    assert_eq!(
        role_of(&mut page.page(&cookie).await).await,
        (json!("viewer"), Value::Null, false)
    );
    assert_eq!(
        bert.ask(json!({"do": "end_session", "session": 2})).await,
        Ok(json!({}))
    );
    assert_eq!(next_answer(&mut script).await, why);
    assert!(writes(&mut bert).await, "the others go on");
    page.bench.plant.close_audit();
    let text = fs::read_to_string(audit.join("000001.jsonl")).expect("it is there");
    let lines = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
    let lines = lines.filter(|line| line["what"] == "end-session" || line["what"] == "logout");
    let told: Vec<_> = lines
        .map(|line| ["what", "from", "object", "result"].map(|key| line[key].as_str().unwrap_or_default().to_owned()))
        .collect();
    let by = told[0][1].clone();
    assert!(by.ends_with(" user:bert"), "{text}");
    let line = |what: &str, from: &str, object: &str, result: &str| [what, from, object, result].map(str::to_owned);
    let expected = [
        line("end-session", &by, "session 9", "refused"),
        line("logout", "127.0.0.1 user:anna", "", "ended by an administrator"),
        line("end-session", &by, "session 1, 127.0.0.1 user:anna", "done"),
        line("logout", "127.0.0.1 token:logger", "", "ended by an administrator"),
        line("end-session", &by, "session 2, 127.0.0.1 token:logger", "done"),
    ];
    assert_eq!(told, expected, "{text}");
}

/// The refusal of the next message of a session: as an answer, or, if the server has closed the socket sooner, as the reason of the close.
async fn next_answer(viewer: &mut Viewer) -> String {
    let request = json!({"id": "next", "do": "write", "tag": "Move1.Speed", "value": 7});
    // A socket that the server has closed takes no message.
    let _ = viewer.socket.send(Message::text(request.to_string())).await;
    loop {
        match timeout(SOON, viewer.socket.next()).await.expect("in time") {
            Some(Ok(Message::Text(text))) => {
                let text: Value = serde_json::from_str(&text).expect("JSON");
                if text["id"] == "next" {
                    return text["error"]["text"].as_str().unwrap_or_default().to_owned();
                }
            }
            Some(Ok(Message::Close(frame))) => {
                let frame = frame.expect("with a reason");
                assert_eq!(u16::from(frame.code), 4401);
                return frame.reason.to_string();
            }
            Some(Ok(_)) => {}
            other => panic!("the server closed without a reason: {other:?}"),
        }
    }
}

#[tokio::test]
async fn the_ninth_session_of_a_user_ends_the_oldest() {
    let page = Secured::start().await;
    let first = page.log_in("anna", ANNA).await.expect("it is her password");
    let mut oldest = page.page(&first).await;
    role_of(&mut oldest).await;
    for _ in 0..8 {
        page.log_in("anna", ANNA).await.expect("it is her password");
    }
    assert_eq!(closed(&mut oldest).await, Some(4401));
}

#[tokio::test]
async fn a_script_shows_a_token() {
    let page = Secured::start().await;
    let bearer = format!("Bearer {TOKEN}");
    let mut script = page.viewer(&[("authorization", &bearer)]).await;
    assert_eq!(role_of(&mut script).await, (json!("operator"), json!("logger"), false));
    assert!(writes(&mut script).await);
    #[rustfmt::skip]
    let cases = [
        ("another token", vec![("authorization", "Bearer arc_0")],                                       401),
        ("no token",      vec![],                                                                        403),
        ("a page",        vec![("authorization", bearer.as_str()), ("origin", "http://evil.example")],   403),
    ];
    for (why, headers, status) in cases {
        match page.connect(&headers).await {
            Err(Error::Http(answer)) => assert_eq!(answer.status(), status, "{why}"),
            other => panic!("{why}: {other:?}"),
        }
    }
    page.change(|users| users.tokens.clear());
    assert_eq!(closed(&mut script).await, Some(4401));
}

/// The two halves of a TLS socket carry long messages both ways at once.
#[tokio::test]
async fn the_page_works_over_https() {
    let page = Secured::start().await;
    let body = json!({"user": "anna", "password": ANNA}).to_string();
    let answer = post(page.encrypted("localhost").await, "/login", "", &body).await;
    assert!(answer.starts_with("HTTP/1.1 204"), "{answer}");
    let cookie = answer
        .lines()
        .find_map(|line| line.strip_prefix("set-cookie: "))
        .expect("a cookie");
    assert!(
        cookie.starts_with("__Host-arcline=") && cookie.ends_with("; Path=/; HttpOnly; SameSite=Strict; Secure"),
        "{cookie}"
    );
    let cookie = cookie.split(';').next().expect("a value");
    let mut request = "wss://cell-4.example/ws".into_client_request().expect("a request");
    request
        .headers_mut()
        .insert("origin", "https://cell-4.example".parse().expect("a header"));
    request
        .headers_mut()
        .insert("cookie", cookie.parse().expect("a header"));
    let (mut socket, _) = client_async(request, page.encrypted("cell-4.example").await)
        .await
        .expect("a place");
    let long = format!("Move1.Speed := {}1;", "1 + ".repeat(50_000));
    let mut session = Value::Null;
    for id in 0..20 {
        let ask = match id % 2 {
            0 => json!({"id": id, "do": "check", "text": long}),
            _ => json!({"id": id, "do": "tags", "pattern": ""}),
        };
        socket.send(Message::text(ask.to_string())).await.expect("it reads");
        loop {
            let message = timeout(SOON, socket.next())
                .await
                .expect("in time")
                .expect("it is open");
            let Message::Text(text) = message.expect("it is open") else {
                continue;
            };
            let text: Value = serde_json::from_str(&text).expect("JSON");
            if text["push"] == "session" {
                session = text;
            } else if text["id"] == id {
                assert!(text["ok"].is_object(), "{text}");
                break;
            }
        }
    }
    assert_eq!(
        (&session["role"], &session["user"]),
        (&json!("operator"), &json!("anna"))
    );
    socket.close(None).await.expect("it is open");
}

/// A page without encryption from elsewhere gets no cookie and offers no log-in; without users nothing asks for one.
#[tokio::test]
async fn without_users_nothing_asks_for_a_login() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let session = viewer.push("session").await;
    assert_eq!(
        session,
        json!({"push": "session", "role": "engineer", "user": null, "locked": false, "can_log_in": false})
    );
}
