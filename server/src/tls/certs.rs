//! `arcline-server certs`: an authority, certificates of the server and of clients, and the list of revoked ones, as files of one folder.
//!
//! A plant that has an authority of its own needs none of this. Keys are P-256; their files are readable by their owner only. The file
//! `issued.txt` has a line for each issued certificate: serial number, name, last day, and the moment of revocation.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Subcommand;
use rcgen::{
    BasicConstraints, CertificateParams, CertificateRevocationListParams, DnType, ExtendedKeyUsagePurpose, IsCa,
    Issuer, KeyIdMethod, KeyPair, KeyUsagePurpose, RevocationReason, RevokedCertParams, SanType, SerialNumber,
};
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject as _;
use time::{Duration, OffsetDateTime};

use super::leaf::Leaf;
use crate::cli::{Failure, print};

/// The commands.
#[derive(Subcommand, Debug)]
pub(crate) enum CertsCommand {
    /// Make an authority and a certificate of the server.
    Init {
        /// The folder of the files.
        #[arg(value_name = "FOLDER")]
        folder: PathBuf,
        /// A name or an address by which clients reach the server; repeat it for several. Those of loopback are always there.
        #[arg(long, value_name = "HOST")]
        host: Vec<String>,
    },
    /// Make a certificate of a client.
    Client {
        /// The folder of the files.
        #[arg(value_name = "FOLDER")]
        folder: PathBuf,
        /// The name of the client, which is the Common Name of the certificate.
        #[arg(value_name = "NAME", value_parser = name)]
        name: String,
        /// Days for which the certificate is valid.
        #[arg(long, value_name = "DAYS", default_value_t = 365, value_parser = clap::value_parser!(u16).range(1..=3650))]
        days: u16,
        /// Replace the files of an earlier certificate of the client, which stays valid until it ends or is revoked.
        #[arg(long)]
        replace: bool,
    },
    /// Make another certificate of the server, with another key.
    Renew {
        /// The folder of the files.
        #[arg(value_name = "FOLDER")]
        folder: PathBuf,
        /// A name or an address by which clients reach the server, as for `init`.
        #[arg(long, value_name = "HOST")]
        host: Vec<String>,
    },
    /// Revoke all certificates of a client: it writes `crl.pem`, the file for `revoked` in `[security]`.
    Revoke {
        /// The folder of the files.
        #[arg(value_name = "FOLDER")]
        folder: PathBuf,
        /// The name of the client.
        #[arg(value_name = "NAME", value_parser = name)]
        name: String,
    },
    /// Show the certificates of a file as `[security]` names them.
    Show {
        /// The file.
        #[arg(value_name = "FILE.pem")]
        file: PathBuf,
    },
}

/// Runs a command.
pub(crate) fn run(command: &CertsCommand) -> Result<ExitCode, Failure> {
    let text = match command {
        CertsCommand::Init { folder, host } => Authority::init(folder).and_then(|authority| authority.server(host)),
        CertsCommand::Renew { folder, host } => Authority::open(folder).and_then(|authority| authority.server(host)),
        CertsCommand::Client {
            folder,
            name,
            days,
            replace,
        } => Authority::open(folder).and_then(|authority| {
            if !replace {
                authority.has_none(name)?;
            }
            authority.client(name, i64::from(*days))
        }),
        CertsCommand::Revoke { folder, name } => Authority::open(folder).and_then(|authority| authority.revoke(name)),
        CertsCommand::Show { file } => show(file),
    };
    print(&text.map_err(|error| Failure::usage(error.to_string()))?)
}

/// The reason for which no certificate was made.
#[derive(Debug, thiserror::Error)]
enum CertsError {
    /// A file cannot be read or written.
    #[error("{}: {error}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The reason.
        error: io::Error,
    },
    /// A client has a certificate already.
    #[error("{} exists; `--replace` makes another certificate in its place, `certs revoke` ends the old one", file.display())]
    Exists {
        /// The file.
        file: PathBuf,
    },
    /// The certificate cannot be made.
    #[error("the certificate cannot be made: {0}")]
    Made(#[from] rcgen::Error),
    /// A file holds no certificate.
    #[error("{}: it holds no certificate", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
    },
    /// No certificate has the name.
    #[error("no certificate of {name:?} was issued by this authority")]
    Unknown {
        /// The name.
        name: String,
    },
}

/// An authority, as the files of its folder.
struct Authority {
    folder: PathBuf,
    issuer: Issuer<'static, KeyPair>,
}

impl Authority {
    fn init(folder: &Path) -> Result<Self, CertsError> {
        fs::create_dir_all(folder).map_err(|error| at(folder, error))?;
        let key = KeyPair::generate()?;
        let cn = format!("Arcline CA {}", super::leaf::hex(&random::<4>()?));
        let mut params = authority(&cn);
        params.serial_number = Some(SerialNumber::from_slice(&serial()?));
        valid(&mut params, 3650);
        let certificate = params.self_signed(&key)?;
        // Created, never replaced: certificates of clients rest on it.
        write_new(&folder.join(CA_KEY), &key.serialize_pem(), PRIVATE)?;
        write_new(&folder.join(CA), &certificate.pem(), PUBLIC)?;
        Self::open(folder)
    }

    fn open(folder: &Path) -> Result<Self, CertsError> {
        let file = folder.join(CA_KEY);
        let key = fs::read_to_string(&file).map_err(|error| at(&file, error))?;
        let key = KeyPair::from_pem(&key)?;
        let [ca, ..] = &read(&folder.join(CA))?[..] else {
            return Err(CertsError::Empty { file: folder.join(CA) });
        };
        Ok(Self {
            folder: folder.to_owned(),
            issuer: Issuer::new(authority(&ca.cn), key),
        })
    }

    /// A certificate of the server; it may also play the part of a client, as CIP devices do.
    fn server(&self, hosts: &[String]) -> Result<String, CertsError> {
        let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        let host = host.trim().to_owned();
        let mut names = vec![SanType::DnsName("localhost".try_into()?)];
        names.extend([Ipv4Addr::LOCALHOST.into(), Ipv6Addr::LOCALHOST.into()].map(SanType::IpAddress));
        for name in hosts.iter().chain([&host].into_iter().filter(|host| !host.is_empty())) {
            names.push(match name.parse::<IpAddr>() {
                Ok(address) => SanType::IpAddress(address),
                Err(_) => SanType::DnsName(name.as_str().try_into()?),
            });
        }
        let mut params = CertificateParams::default();
        params.subject_alt_names = names;
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth, ExtendedKeyUsagePurpose::ClientAuth];
        self.issue(params, "server", 365)?;
        Ok(format!(
            "{folder}: {CA}, server.pem and server.key; clients need {CA} and a certificate of their own (`arcline-server certs client {folder} NAME`)\n",
            folder = self.folder.display()
        ))
    }

    /// A key that is overwritten is lost, and with it the client that uses it.
    fn has_none(&self, name: &str) -> Result<(), CertsError> {
        for kind in ["pem", "key"] {
            let file = self.folder.join(format!("{name}.{kind}"));
            if fs::symlink_metadata(&file).is_ok() {
                return Err(CertsError::Exists { file });
            }
        }
        Ok(())
    }

    fn client(&self, name: &str, days: i64) -> Result<String, CertsError> {
        let mut params = CertificateParams::default();
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ClientAuth];
        let leaf = self.issue(params, name, days)?;
        Ok(format!(
            "{}: {name}.pem and {name}.key\n\n[[security.certificates]]\ncn = {:?}\nissuer = {:?}\nrole = \"operator\"\n",
            self.folder.display(),
            leaf.cn,
            leaf.issuer
        ))
    }

    /// Signs a certificate and writes it and its key.
    fn issue(&self, mut params: CertificateParams, name: &str, days: i64) -> Result<Leaf, CertsError> {
        let key = KeyPair::generate()?;
        params.distinguished_name.remove(DnType::CommonName);
        params.distinguished_name.push(DnType::CommonName, name);
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.use_authority_key_identifier_extension = true;
        params.serial_number = Some(SerialNumber::from_slice(&serial()?));
        valid(&mut params, days);
        let certificate = params.signed_by(&key, &self.issuer)?;
        let file = |kind: &str| self.folder.join(format!("{name}.{kind}"));
        let leaf = Leaf::read(certificate.der()).ok_or_else(|| CertsError::Empty { file: file("pem") })?;
        // Listed first: a certificate that is not in the list could not be revoked.
        let issued = self.folder.join(ISSUED);
        let listed = OpenOptions::new()
            .create(true)
            .append(true)
            .mode(PRIVATE)
            .open(&issued)
            .and_then(|mut list| {
                writeln!(list, "{} {name} {}", leaf.serial, leaf.valid.1)?;
                list.sync_data()
            });
        listed.map_err(|error| at(&issued, error))?;
        write(&file("key"), &key.serialize_pem(), PRIVATE)?;
        write(&file("pem"), &certificate.pem(), PUBLIC)?;
        Ok(leaf)
    }

    fn revoke(&self, name: &str) -> Result<String, CertsError> {
        let issued = self.folder.join(ISSUED);
        let list = fs::read_to_string(&issued).map_err(|error| at(&issued, error))?;
        let now = OffsetDateTime::now_utc();
        let mut lines = Vec::new();
        let mut revoked = Vec::new();
        let mut count = 0;
        for line in list.lines() {
            let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            if words.len() == 3 && words.get(1).is_some_and(|of| of == name) {
                words.push(now.unix_timestamp().to_string());
                count += 1;
            }
            if let [serial, _, _, at] = words.as_slice() {
                let at = at
                    .parse()
                    .ok()
                    .and_then(|at| OffsetDateTime::from_unix_timestamp(at).ok());
                revoked.push(RevokedCertParams {
                    serial_number: SerialNumber::from_slice(&bytes_of(serial)),
                    revocation_time: at.unwrap_or(now),
                    reason_code: Some(RevocationReason::CessationOfOperation),
                    invalidity_date: None,
                });
            }
            lines.push(words.join(" "));
        }
        if count == 0 {
            return Err(CertsError::Unknown { name: name.to_owned() });
        }
        let crl = CertificateRevocationListParams {
            this_update: now - HOUR,
            next_update: now + Duration::days(3650),
            crl_number: SerialNumber::from(now.unix_timestamp().unsigned_abs()),
            issuing_distribution_point: None,
            revoked_certs: revoked,
            key_identifier_method: KeyIdMethod::Sha256,
        };
        let crl = crl.signed_by(&self.issuer)?;
        write(&self.folder.join(CRL), &crl.pem()?, PUBLIC)?;
        write(&issued, &format!("{}\n", lines.join("\n")), PRIVATE)?;
        Ok(format!(
            "{file}: {count} of {name}; a running server whose [security] names this file as `revoked` reads it within a minute, or at \
             SIGHUP. A server without `revoked` still accepts the client\n",
            file = self.folder.join(CRL).display()
        ))
    }
}

/// The certificates of a file, as rows name them.
fn show(file: &Path) -> Result<String, CertsError> {
    let all = read(file)?;
    if all.is_empty() {
        return Err(CertsError::Empty { file: file.to_owned() });
    }
    let one = |leaf: &Leaf| {
        let day = |at: i64| {
            OffsetDateTime::from_unix_timestamp(at).map_or_else(|_| at.to_string(), |at| at.date().to_string())
        };
        let Leaf {
            cn,
            issuer,
            sha256,
            serial,
            valid,
            names: _,
        } = leaf;
        format!(
            "cn = {cn:?}\nissuer = {issuer:?}\nsha256 = {sha256:?}\n# serial number {serial}, from {} to {}\n",
            day(valid.0),
            day(valid.1)
        )
    };
    Ok(all.iter().map(one).collect::<Vec<_>>().join("\n"))
}

fn read(file: &Path) -> Result<Vec<Leaf>, CertsError> {
    let pem = fs::read(file).map_err(|error| at(file, error))?;
    let certificates = CertificateDer::pem_slice_iter(&pem).flatten();
    Ok(certificates.filter_map(|one| Leaf::read(&one)).collect())
}

/// The authority's own parameters, which follow from its name: its certificates are found by it.
fn authority(cn: &str) -> CertificateParams {
    let mut params = CertificateParams::default();
    params.distinguished_name.remove(DnType::CommonName);
    params.distinguished_name.push(DnType::CommonName, cn);
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    params
}

/// Validity begins an hour ago, since the clock of a client may be behind.
fn valid(params: &mut CertificateParams, days: i64) {
    let now = OffsetDateTime::now_utc();
    (params.not_before, params.not_after) = (now - HOUR, now + Duration::days(days));
}

/// A positive serial number that no other certificate has.
fn serial() -> Result<[u8; 16], CertsError> {
    let mut serial = random()?;
    if let Some(first) = serial.first_mut() {
        *first = *first & 0x7F | 0x40;
    }
    Ok(serial)
}

fn random<const N: usize>() -> Result<[u8; N], CertsError> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|error| at(Path::new("random numbers"), io::Error::other(error)))?;
    Ok(bytes)
}

fn bytes_of(hex: &str) -> Vec<u8> {
    let pairs = (0..hex.len()).step_by(2).filter_map(|at| hex.get(at..at + 2));
    pairs.filter_map(|pair| u8::from_str_radix(pair, 16).ok()).collect()
}

fn at(file: &Path, error: io::Error) -> CertsError {
    CertsError::File {
        file: file.to_owned(),
        error,
    }
}

fn write_new(file: &Path, text: &str, mode: u32) -> Result<(), CertsError> {
    let opened = OpenOptions::new().write(true).create_new(true).mode(mode).open(file);
    opened
        .and_then(|mut opened| opened.write_all(text.as_bytes()))
        .map_err(|error| at(file, error))
}

/// Replaces a file as a whole.
fn write(file: &Path, text: &str, mode: u32) -> Result<(), CertsError> {
    let mut new = file.as_os_str().to_owned();
    new.push(".new");
    let new = PathBuf::from(new);
    let _ = fs::remove_file(&new);
    write_new(&new, text, mode)?;
    fs::rename(&new, file).map_err(|error| at(file, error))
}

/// The name of a client becomes the name of a file.
fn name(text: &str) -> Result<String, String> {
    let is_name = (1..=64).contains(&text.len())
        && text
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte))
        && !text.starts_with('.')
        && !["ca", "server"].contains(&text);
    match is_name {
        true => Ok(text.to_owned()),
        false => Err("expected 1 to 64 letters, digits, `-`, `_` and `.`, not `ca` or `server`".to_owned()),
    }
}

const CA: &str = "ca.pem";
const CA_KEY: &str = "ca.key";
const CRL: &str = "crl.pem";
const ISSUED: &str = "issued.txt";
const PRIVATE: u32 = 0o600;
const PUBLIC: u32 = 0o644;
const HOUR: Duration = Duration::hours(1);
