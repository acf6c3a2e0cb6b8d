//! Start-up, the ready line, signals, and a controlled end.

use std::io::{self, Write as _};
use std::net::SocketAddr;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use arcline_cell::{Surroundings, UnknownParts};
use arcline_config::{IoListen, Project, ServerConfig};
use arcline_controller::image::Image;
use arcline_realtime::Clock;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use tokio::signal::unix::{self, SignalKind};
use tokio::sync::oneshot;

use crate::audit::{self, Audit, EventKind};
use crate::cli::{Failure, OrOff, RunArgs, project};
use crate::eip::{BindError, Listener, Settings};
use crate::hmi::{self, Hmi, ListenSettings, Sessions};
use crate::live;
use crate::plant::{Mode, Plant, Principal};
use crate::retained::{ChangeTracker, Retained, StateWriter};
use crate::systemd::Supervisor;
use crate::tls::Tls;

/// Runs the server until SIGTERM or SIGINT.
pub(crate) fn run(args: &RunArgs, program: Option<(PathBuf, bool)>) -> Result<ExitCode, Failure> {
    let mut project = match (&args.config, &program) {
        (None, Some((file, _))) => live::configuration(file)?,
        (config, _) => project(config.as_deref())?,
    };
    // The configuration as the server read it; a reload compares the new one with it.
    let configured = project.clone();
    if let Some((first, also)) = args.listen.split_first() {
        project.server.listen = *first;
        project.server.listen_also = also.to_vec();
    }
    let hmi = match &args.hmi {
        Some(OrOff::On(address)) => Some(HmiAt::Chosen(*address)),
        Some(OrOff::Off) => None,
        None if project.server.hmi == ServerConfig::default().hmi => project.server.hmi.map(HmiAt::Default),
        None => project.server.hmi.map(HmiAt::Chosen),
    };
    check_open(&project.server, hmi, args)?;
    let has_program = program.is_some() || project.server.controller.program.is_some();
    if args.clock == Clock::Step && has_program {
        return Err(Failure::usage(
            "--clock step: the tasks of a project follow real time; `simulate PROJECT.L5X` runs them on the virtual clock",
        ));
    }
    let (retained, state_writer) = match &args.state {
        Some(OrOff::On(file)) => {
            let retained = Retained::open(file, &mut project).map_err(|error| Failure::usage(error.to_string()))?;
            (Some((retained.image, retained.watch)), Some(retained.writer))
        }
        Some(OrOff::Off) | None => (None, None),
    };
    let audit = open_audit(&project.server, args)?;
    raise_descriptors(project.server.max_clients);
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(workers())
        .enable_all()
        .build()
        .map_err(|error| Failure::new(1, format!("the runtime could not be started: {error}")))?;
    let start = Start {
        hmi,
        retained,
        audit,
        config: args.config.as_deref(),
        clock: args.clock,
        end_with_stdin: args.end_with_stdin,
        program: program_of(&project.server, args.config.as_deref(), program),
    };
    let (plant, handle) = runtime.block_on(serve(&project, start, configured))?;
    // The thread stops all motion and waits until it stands still; no client is heard any more.
    handle.stop();
    plant.retain_at_the_end();
    plant.record(Principal::Server, EventKind::Stop, String::new(), "done");
    plant.close_audit();
    match state_writer.map(StateWriter::close) {
        None | Some(Ok(())) => Ok(ExitCode::SUCCESS),
        Some(Err(error)) => Err(Failure::new(1, format!("the state could not be saved: {error}"))),
    }
}

/// The settings of a server beside its project.
struct Start<'a> {
    hmi: Option<HmiAt>,
    retained: Option<(Image, ChangeTracker)>,
    audit: Option<Audit>,
    config: Option<&'a Path>,
    clock: Clock,
    end_with_stdin: bool,
    program: Option<live::ProgramSettings>,
}

/// The program of the command line, or of the configuration.
fn program_of(
    server: &ServerConfig,
    config: Option<&Path>,
    given: Option<(PathBuf, bool)>,
) -> Option<live::ProgramSettings> {
    let has_machine = config.is_none() && given.is_some();
    let controller = &server.controller;
    let (file, allow_missing) = match (given, &controller.program) {
        (Some(given), _) => given,
        (None, Some(program)) => {
            let folder = config.and_then(Path::parent).unwrap_or(Path::new(""));
            (folder.join(program), controller.allow_missing)
        }
        (None, None) => return None,
    };
    let mode = if controller.begins_stopped {
        Mode::Program
    } else {
        Mode::Run
    };
    let unknown_parts = if allow_missing {
        UnknownParts::Allowed
    } else {
        UnknownParts::Refused
    };
    Some(live::ProgramSettings {
        file,
        mode,
        unknown_parts,
        has_machine,
        around: Surroundings::of(controller),
    })
}

/// The audit, where there is to be one.
fn open_audit(server: &ServerConfig, args: &RunArgs) -> Result<Option<Audit>, Failure> {
    let folder = match (&args.audit, &args.state) {
        (Some(OrOff::On(folder)), _) => folder.clone(),
        (None, Some(OrOff::On(state))) if server.security.is_given => audit::folder_of(state),
        _ => return Ok(None),
    };
    let audit = Audit::open(&folder);
    let audit = audit.map_err(|error| Failure::usage(format!("--audit {}: {error}", folder.display())))?;
    Ok(Some(audit))
}

async fn serve(
    project: &Project,
    start: Start<'_>,
    mut configured: Project,
) -> Result<(Plant, arcline_realtime::Handle), Failure> {
    let mut signals = Signals::new()?;
    let end_with_stdin = start.end_with_stdin;
    let (hmi, config, clock) = (start.hmi, start.config, start.clock);
    let (plant, handle, program) = start_plant(project, start)?;
    let Sockets { listener, hmi, tls } = open(project, hmi, config, &plant).await?;
    let live = program.map(|program| program.spawn(&plant)).transpose();
    let live = live.map_err(|error| failed("no thread for the program", &error))?;
    ready(&Bound {
        eip: listener.local_addr(),
        hmi: hmi.as_ref().and_then(Hmi::local_addr),
        tls: listener.tls_addr(),
        hmi_tls: hmi.as_ref().and_then(Hmi::tls_addr),
    })
    .map_err(|error| failed("standard output", &error))?;
    let supervisor = Supervisor::of_environment();
    if let Some(supervisor) = &supervisor {
        supervisor.ready();
    }
    let watched_plant = plant.clone();
    let watched = async {
        match &supervisor {
            Some(supervisor) => supervisor.watch(&watched_plant, clock).await,
            None => std::future::pending().await,
        }
    };
    tokio::pin!(watched);
    let served = async {
        tokio::join!(listener.serve(), async {
            if let Some(hmi) = hmi {
                hmi.serve().await;
            }
        });
    };
    tokio::pin!(served);
    if end_with_stdin {
        signals.watch_input()?;
    }
    loop {
        let signal = tokio::select! {
            () = &mut served => break,
            () = &mut watched => continue,
            signal = signals.next() => signal,
        };
        match signal {
            Signal::End(why) => {
                tracing::info!("{why}: stopping");
                break;
            }
            Signal::Reload => {
                let new = config.map(|file| self::project(Some(file)));
                if let Some(tls) = &tls {
                    if let Some(Ok(new)) = &new {
                        tls.set_roles(&new.server.security, &plant);
                    }
                    tls.reload(&plant);
                }
                match (config.zip(new), &live) {
                    (Some((file, new)), _) => reload(&plant, file, new, &mut configured).await,
                    (None, None) => {
                        tracing::warn!("SIGHUP: nothing was reloaded, since the server runs without --config")
                    }
                    (None, Some(_)) => {}
                }
                if let Some(live) = &live {
                    reload_program(&plant, live);
                }
            }
        }
    }
    if let Some(supervisor) = &supervisor {
        supervisor.stopping();
    }
    if let Some(live) = live {
        live.stop();
    }
    Ok((plant, handle))
}

fn failed(what: &str, error: &dyn std::fmt::Display) -> Failure {
    Failure::new(1, format!("{what}: {error}"))
}

/// Starts the controller with the tags that it begins with, and its audit; the program is loaded and does not run yet.
fn start_plant(
    project: &Project,
    start: Start<'_>,
) -> Result<(Plant, arcline_realtime::Handle, Option<live::Prepared>), Failure> {
    let (mut image, watch) = match start.retained {
        None => (project.image(), None),
        Some((image, watch)) => (image, Some(watch)),
    };
    if start.clock == Clock::Step {
        image.add_clock_step();
    }
    let program = start.program;
    let program = program.map(|settings| live::Prepared::load(settings, &project.machine, &mut image));
    let program = program.transpose()?;
    let started = Plant::start_with(project, image, watch, start.clock);
    let (plant, handle) = started.map_err(|error| Failure::new(1, error.to_string()))?;
    if let Some(audit) = start.audit {
        plant.set_audit(audit);
        plant.record(
            Principal::Server,
            EventKind::Start,
            env!("CARGO_PKG_VERSION").to_owned(),
            "done",
        );
    }
    Ok((plant, handle, program))
}

/// The open sockets of a server.
struct Sockets {
    listener: Listener,
    hmi: Option<Hmi>,
    tls: Option<Arc<Tls>>,
}

/// Opens the sockets of EtherNet/IP and of the page.
async fn open(project: &Project, hmi: Option<HmiAt>, config: Option<&Path>, plant: &Plant) -> Result<Sockets, Failure> {
    let mut settings = Settings::new(&project.server);
    let security = &project.server.security;
    let folder = config.and_then(Path::parent).unwrap_or(Path::new(""));
    if security.tls.or(security.hmi_tls).is_some() {
        let tls = Tls::new(security, folder);
        settings.tls = Some(tls.map_err(|error| Failure::usage(error.to_string()))?);
    }
    let sessions = Sessions::open(security, folder).map_err(|error| {
        let hint = "`arcline-server users add FILE NAME --role ROLE` makes the file";
        Failure::usage(format!("{error}; {hint}"))
    })?;
    let tls = settings.tls.clone();
    let listener = bind(project.server.listen, plant.clone(), settings).await?;
    if let Some(address) = listener.io_addr() {
        tracing::info!(%address, "implicit I/O (class 0 and 1 connections) listens");
    }
    let listen_settings = ListenSettings {
        plain: None,
        tls: security.hmi_tls.zip(tls.clone()),
        sessions: Some(Arc::new(sessions)),
    };
    let hmi = match (hmi, security.hmi_tls) {
        (None, None) => None,
        (at, _) => Some(bind_hmi(at, listen_settings, plant.clone()).await?),
    };
    Ok(Sockets { listener, hmi, tls })
}

/// The signals of the system, and the end of standard input.
struct Signals {
    terminate: unix::Signal,
    interrupt: unix::Signal,
    hangup: unix::Signal,
    /// `None`: it does not matter.
    input: Option<oneshot::Receiver<()>>,
}

/// The request of a signal.
enum Signal {
    /// Read the configuration, certificates and program again.
    Reload,
    /// End, with the reason.
    End(&'static str),
}

impl Signals {
    fn new() -> Result<Self, Failure> {
        let of = |kind, name| unix::signal(kind).map_err(|error| failed(name, &error));
        Ok(Self {
            terminate: of(SignalKind::terminate(), "SIGTERM")?,
            interrupt: of(SignalKind::interrupt(), "SIGINT")?,
            hangup: of(SignalKind::hangup(), "SIGHUP")?,
            input: None,
        })
    }

    /// The end of standard input is a signal from now on.
    fn watch_input(&mut self) -> Result<(), Failure> {
        let input = end_of_input().map_err(|error| failed("standard input", &error))?;
        self.input = Some(input);
        Ok(())
    }

    /// The next one.
    async fn next(&mut self) -> Signal {
        tokio::select! {
            _ = self.hangup.recv() => Signal::Reload,
            _ = self.terminate.recv() => Signal::End("SIGTERM"),
            () = ended(&mut self.input) => Signal::End("standard input has closed"),
            _ = self.interrupt.recv() => Signal::End("SIGINT"),
        }
    }
}

/// Is ready when standard input has closed. No other thread reads standard input.
fn end_of_input() -> io::Result<oneshot::Receiver<()>> {
    let (closed, input) = oneshot::channel();
    std::thread::Builder::new()
        .name("arcline-stdin".to_owned())
        .spawn(move || {
            // Discard the input: it is not for the server. An error ends the input too.
            let _ = io::copy(&mut io::stdin().lock(), &mut io::sink());
            let _ = closed.send(());
        })?;
    Ok(input)
}

/// Waits for the end of standard input; for ever, where that does not matter.
async fn ended(input: &mut Option<oneshot::Receiver<()>>) {
    match input {
        // The thread ends in no other way.
        Some(input) => drop(input.await),
        None => std::future::pending().await,
    }
}

/// SIGHUP: takes over the program of the controller as its file is now, or logs the reason.
fn reload_program(plant: &Plant, live: &live::Live) {
    match tokio::task::block_in_place(|| live.reload(plant)) {
        Ok(()) => {
            plant.record(
                Principal::Server,
                EventKind::Reload,
                "the program of the controller".to_owned(),
                "done",
            );
            tracing::warn!("Reloaded the program of the controller");
        }
        Err(failure) => tracing::error!("Reload refused: {failure}"),
    }
}

/// Refuses to listen beyond this computer without `[security]`, unless the user allows it; then a banner names the risk.
fn check_open(server: &ServerConfig, hmi: Option<HmiAt>, args: &RunArgs) -> Result<(), Failure> {
    let page = hmi.map(|(HmiAt::Chosen(address) | HmiAt::Default(address))| address);
    let Some(open) = open_without_security(server, page) else {
        return Ok(());
    };
    if !args.open_to_network {
        return Err(Failure::usage(format!(
            "{open} is reachable from other computers, and the configuration has no [security]; add that table (SECURITY.md), or say \
             --open-to-network to let clients elsewhere look and stop"
        )));
    }
    let (loopback, remote) = (server.security.loopback.word(), server.security.remote_plain.word());
    eprintln!(
        "\n  *** OPEN TO THE NETWORK: {open} is reachable from other computers, without encryption.\n  \
         *** Clients on this computer have the role {loopback}, all others the role {remote}: see SECURITY.md.\n"
    );
    Ok(())
}

/// The first address that other computers reach, on a server without `[security]`.
pub(crate) fn open_without_security(server: &ServerConfig, page: Option<SocketAddr>) -> Option<SocketAddr> {
    if server.security.is_given {
        return None;
    }
    let eip = [server.listen].into_iter().chain(server.listen_also.iter().copied());
    let mut listeners = eip.chain(page).chain(server.io.address(server.listen));
    listeners.find(|address| !address.ip().to_canonical().is_loopback())
}

/// Raises the limit of open files as far as the clients may need it and the system allows it: beyond the limit no newcomer gets in.
fn raise_descriptors(clients: usize) {
    let wanted = u64::try_from(clients)
        .unwrap_or(u64::MAX)
        .saturating_add(SPARE_DESCRIPTORS);
    let limit = getrlimit(Resource::Nofile);
    let Some(now) = limit.current.filter(|now| *now < wanted) else {
        return;
    };
    let raised = limit.maximum.map_or(wanted, |most| wanted.min(most));
    let new = Rlimit {
        current: Some(raised),
        ..limit
    };
    if raised < wanted || setrlimit(Resource::Nofile, new).is_err() {
        tracing::warn!(
            limit = raised.max(now),
            wanted,
            "the system limits open files below what `max_clients` needs: newcomers close silent clients earlier"
        );
    }
}

/// Descriptors beside those of EtherNet/IP clients: the page's connections and viewers, files, and the server's own.
pub(crate) const SPARE_DESCRIPTORS: u64 = 512;

/// SIGHUP: takes over the tags and types of the configuration file as it is now, or logs the reason. The result is a
/// warning, so that the default log level shows it.
async fn reload(plant: &Plant, file: &Path, new: Result<Project, Failure>, configured: &mut Project) {
    let new = match new {
        Ok(new) => new,
        Err(failure) => {
            tracing::error!("Reload refused: {failure}");
            return;
        }
    };
    match plant.reload(configured, &new).await {
        Ok(()) => {
            *configured = new;
            tracing::warn!("Reloaded {}", file.display());
        }
        Err(error) => tracing::error!("{}: {error}", file.display()),
    }
}

/// Binds all sockets. Where the configuration has no port for implicit I/O and 2222 is in use (by a scanner on this host), any free
/// port does: the reply to a Forward Open has it.
async fn bind(listen: SocketAddr, plant: Plant, mut settings: Settings) -> Result<Listener, Failure> {
    let io = settings.config.io.address(listen);
    let error = match Listener::bind(listen, plant.clone(), settings.clone()).await {
        Err(error) if settings.config.io == IoListen::BesideListen && io == Some(error.address) => error,
        bound => return bound.map_err(|error| cannot_listen(&error, io)),
    };
    tracing::warn!(%error, "the default port of implicit I/O is in use: implicit I/O uses another one");
    settings.config.io = IoListen::At(SocketAddr::new(error.address.ip(), 0));
    Listener::bind(listen, plant, settings)
        .await
        .map_err(|error| cannot_listen(&error, io))
}

/// The addresses at which the server listens.
struct Bound {
    eip: SocketAddr,
    hmi: Option<SocketAddr>,
    tls: Option<SocketAddr>,
    hmi_tls: Option<SocketAddr>,
}

/// The line that scripts wait for.
fn ready(bound: &Bound) -> io::Result<()> {
    let mut out = io::stdout().lock();
    let hmi = bound
        .hmi
        .map_or_else(|| "off".to_owned(), |address| address.to_string());
    write!(out, "ready eip={} hmi={hmi}", bound.eip)?;
    for (key, address) in [("tls", bound.tls), ("hmi_tls", bound.hmi_tls)] {
        if let Some(address) = address {
            write!(out, " {key}={address}")?;
        }
    }
    writeln!(out)?;
    out.flush()
}

/// The address of the web page.
#[derive(Clone, Copy, Debug)]
enum HmiAt {
    /// An address of the configuration or the command line.
    Chosen(SocketAddr),
    /// The default port, or a free one when it is in use: the ready line has it.
    Default(SocketAddr),
}

async fn bind_hmi(at: Option<HmiAt>, settings: ListenSettings, plant: Plant) -> Result<Hmi, Failure> {
    let plain = at.map(|(HmiAt::Chosen(address) | HmiAt::Default(address))| address);
    let settings = ListenSettings { plain, ..settings };
    let error = match Hmi::bind_all(settings.clone(), plant.clone()).await {
        Ok(hmi) => return Ok(hmi),
        Err(error) => error,
    };
    let Some(HmiAt::Default(address)) = at else {
        return Err(no_hmi(&error));
    };
    if error.error.kind() != io::ErrorKind::AddrInUse || error.address != address {
        return Err(no_hmi(&error));
    }
    tracing::warn!(%address, "another program uses the default port of the web page: the ready line has the port of this server");
    let plain = Some(SocketAddr::new(address.ip(), 0));
    Hmi::bind_all(ListenSettings { plain, ..settings }, plant)
        .await
        .map_err(|error| no_hmi(&error))
}

fn no_hmi(hmi::BindError { address, error }: &hmi::BindError) -> Failure {
    let hint = "choose another address with --hmi ADDR:PORT or `hmi_tls`, or --hmi off";
    Failure::new(1, format!("cannot listen on {address} for the HMI: {error}; {hint}"))
}

fn cannot_listen(BindError { address, error }: &BindError, io: Option<SocketAddr>) -> Failure {
    let hint = match error.kind() {
        _ if io == Some(*address) => "; choose another address for implicit I/O with `io` in [server], or \"off\"",
        io::ErrorKind::AddrInUse => "; another program uses the port, choose one with --listen ADDR:PORT",
        io::ErrorKind::PermissionDenied => "; ports below 1024 need rights, choose another with --listen ADDR:PORT",
        _ => "",
    };
    Failure::new(1, format!("cannot listen on {address}: {error}{hint}"))
}

/// Threads of the runtime that serves the network: one processor is left to the tick and its kin, which have threads of their
/// own. With fewer threads than processors a thread is seldom woken by another, which costs more than an answer.
fn workers() -> usize {
    let processors = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    processors.saturating_sub(1).clamp(1, MOST_WORKERS)
}

/// The network is light work.
const MOST_WORKERS: usize = 4;
