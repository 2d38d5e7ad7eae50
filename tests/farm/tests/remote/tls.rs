//! `bake build --remote grpcs://...`: certificates that are right, and all that can be wrong.

use std::fs;
use std::path::Path;

use hullmap_outside::command::Run;
use hullmap_outside::files::contents;
use rcgen::{BasicConstraints, CertificateParams, IsCa, Issuer, KeyPair};
use tempfile::TempDir;

use crate::build::checkout;
use crate::farm_server::{FarmServer, Tls};
use crate::{binary, run};

/// A certificate authority.
struct Authority {
    pem: String,
    issuer: Issuer<'static, KeyPair>,
}

impl Authority {
    fn new() -> Self {
        let key = KeyPair::generate().unwrap();
        let mut parameters = CertificateParams::new(Vec::new()).unwrap();
        parameters.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let pem = parameters.self_signed(&key).unwrap().pem();
        Self { pem, issuer: Issuer::new(parameters, key) }
    }

    /// A certificate for a name, and its key.
    fn sign(&self, name: &str) -> (String, String) {
        self.sign_parameters(CertificateParams::new([name.to_owned()]).unwrap())
    }

    fn sign_parameters(&self, parameters: CertificateParams) -> (String, String) {
        let key = KeyPair::generate().unwrap();
        (parameters.signed_by(&key, &self.issuer).unwrap().pem(), key.serialize_pem())
    }
}

fn server((certificate, key): (String, String), clients: Option<&Authority>) -> FarmServer {
    FarmServer::start_with(Some(Tls { certificate, key, clients: clients.map(|authority| authority.pem.clone()) }))
}

/// A checkout with files in PEM format.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    checkout(folder.path());
    files.iter().for_each(|(name, text)| fs::write(folder.path().join(name), text).unwrap());
    folder
}

fn build(folder: &Path, scheme: &str, host: &str, server: &FarmServer, more: &str) -> Run {
    let (port, worker) = (server.address.port(), binary().display());
    let line = format!("build in --out o --remote {scheme}://{host}:{port} --remote-worker {worker} {more}");
    run(folder, &line)
}

#[test]
fn packs_travel_encrypted() {
    let authority = Authority::new();
    let server = server(authority.sign("localhost"), None);
    let folder = folder(&[("ca.pem", &authority.pem)]);
    run(folder.path(), "build in --out local").expect(0);
    let more = "--remote-ca ca.pem --remote-header authorization=secret";
    build(folder.path(), "grpcs", "localhost", &server, more).expect(0);
    assert_eq!(contents(&folder.path().join("o")), contents(&folder.path().join("local")));
    assert_eq!(server.state.lock().unwrap().headers["authorization"], "secret");
}

#[test]
fn certificates_of_servers_are_checked_and_headers_stay_here() {
    let (authority, stranger) = (Authority::new(), Authority::new());
    let folder = folder(&[
        ("ca.pem", &authority.pem),
        ("stranger.pem", &stranger.pem),
        ("none.pem", "no certificate"),
        ("broken.pem", "-----BEGIN CERTIFICATE-----\n%%%\n-----END CERTIFICATE-----\n"),
    ]);
    let good = server(authority.sign("localhost"), None);
    let other_name = server(authority.sign("farm.example"), None);
    let mut parameters = CertificateParams::new(["localhost".to_owned()]).unwrap();
    (parameters.not_before, parameters.not_after) =
        (rcgen::date_time_ymd(2020, 1, 1), rcgen::date_time_ymd(2021, 1, 1));
    let expired = server(authority.sign_parameters(parameters), None);
    let own = "--remote-ca ca.pem";
    for (scheme, server, flags, reason) in [
        ("grpcs", &good, "--remote-ca stranger.pem", "but another key"),
        ("grpcs", &good, "", "its issuer is not trusted"),
        ("grpcs", &other_name, own, "not valid for name"),
        ("grpcs", &expired, own, "expired"),
        ("grpcs", &good, "--remote-ca none.pem", "--remote-ca none.pem: it has no unencrypted part in PEM format"),
        ("grpcs", &good, "--remote-ca broken.pem", "certificate"),
        ("grpcs", &good, "--remote-ca missing.pem", "--remote-ca missing.pem: cannot read"),
        ("grpc", &good, own, "use grpcs://"),
        ("grpc", &good, "", "perhaps it expects TLS (grpcs://)"),
    ] {
        let run = build(folder.path(), scheme, "localhost", server, &format!("{flags} --remote-header a=secret"));
        let run = run.expect(2);
        assert!(run.stderr.contains(reason) && !run.stderr.contains("secret"), "{scheme} {flags}: {}", run.stderr);
        assert_eq!(server.requests("GetCapabilities"), 0, "{scheme} {flags}: no request arrived");
    }
}

/// TLS is requested of a plain server.
#[test]
fn a_server_without_tls_is_named() {
    let authority = Authority::new();
    let folder = folder(&[("ca.pem", &authority.pem)]);
    let run = build(folder.path(), "grpcs", "127.0.0.1", &FarmServer::start(), "--remote-ca ca.pem").expect(2);
    assert!(run.stderr.contains("does not use TLS"), "{}", run.stderr);
}

#[test]
fn servers_may_require_certificates_of_clients() {
    let (authority, stranger) = (Authority::new(), Authority::new());
    let server = server(authority.sign("localhost"), Some(&authority));
    let (own, strange) = (authority.sign("client"), stranger.sign("client"));
    let folder = folder(&[
        ("ca.pem", &authority.pem),
        ("own.pem", &own.0),
        ("own.key", &own.1),
        ("strange.pem", &strange.0),
        ("strange.key", &strange.1),
        ("encrypted.key", "-----BEGIN ENCRYPTED PRIVATE KEY-----\nAAAA\n-----END ENCRYPTED PRIVATE KEY-----\n"),
    ]);
    let with =
        |flags: &str| build(folder.path(), "grpcs", "localhost", &server, &format!("--remote-ca ca.pem {flags}"));
    for (flags, reason) in [
        // The alert, or only the end of the connection that follows it.
        ("", "certificate of the client"),
        ("--remote-client-cert strange.pem --remote-client-key strange.key", "the certificate of the client"),
        ("--remote-client-cert own.pem --remote-client-key strange.key", "KeyMismatch"),
        ("--remote-client-cert own.pem --remote-client-key encrypted.key", "no unencrypted part"),
        ("--remote-client-cert own.pem --remote-client-key own.pem", "PRIVATE KEY-----"),
        ("--remote-client-cert own.pem", "--remote-client-key"),
    ] {
        let run = with(flags).expect(2);
        assert!(run.stderr.contains(reason), "{flags}: {}", run.stderr);
        assert!(!run.stderr.contains(&own.1[60..80]), "a key is in no message");
    }
    assert_eq!(server.requests("GetCapabilities"), 0);
    with("--remote-client-cert own.pem --remote-client-key own.key").expect(0);
}
