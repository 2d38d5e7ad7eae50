//! Address, headers and limits of a client.

use std::fmt;
use std::net::IpAddr;
use std::str::FromStr;
use std::time::Duration;

/// Address of a server: `grpc://HOST:PORT`, or `grpcs://HOST:PORT` with TLS.
///
/// ```
/// use hullmap_remote::Address;
///
/// let address: Address = "grpcs://farm.example:443".parse()?;
/// assert!(address.uses_tls());
/// assert!("http://farm.example".parse::<Address>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    /// Host and port.
    authority: String,
    uses_tls: bool,
}

impl Address {
    /// Whether the connection is encrypted and the server has a certificate.
    pub fn uses_tls(&self) -> bool {
        self.uses_tls
    }

    /// Whether the server is this machine, so that nobody reads what is sent.
    ///
    /// ```
    /// let is_local = |text: &str| text.parse::<hullmap_remote::Address>().is_ok_and(|address| address.is_local());
    /// assert!(is_local("grpc://localhost:1") && is_local("grpc://[::1]:1") && !is_local("grpc://farm:1"));
    /// ```
    pub fn is_local(&self) -> bool {
        let host = self.authority.rsplit_once(':').map_or(self.authority.as_str(), |(host, _)| host);
        let address = host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        host.eq_ignore_ascii_case("localhost") || address.is_ok_and(|address| address.is_loopback())
    }

    /// The address as the transport takes it.
    pub(crate) fn uri(&self) -> String {
        format!("{}://{}", if self.uses_tls { "https" } else { "http" }, self.authority)
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}://{}", if self.uses_tls { "grpcs" } else { "grpc" }, self.authority)
    }
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected grpc://HOST:PORT or grpcs://HOST:PORT; found `{text}`");
        let (scheme, authority) = text.split_once("://").ok_or_else(expected)?;
        let uses_tls = match scheme {
            "grpc" => false,
            "grpcs" => true,
            _ => return Err(expected()),
        };
        let authority = authority.strip_suffix('/').unwrap_or(authority);
        let (host, port) = authority.rsplit_once(':').ok_or_else(expected)?;
        // A user name or password in the address would be sent nowhere.
        let is_host = !host.is_empty() && !host.contains(['/', '@', '?', '#', ' ']);
        if !is_host || port.parse::<u16>().is_err() {
            return Err(expected());
        }
        Ok(Self { authority: authority.to_owned(), uses_tls })
    }
}

/// A client's own certificate, for servers that require one.
#[derive(Clone)]
pub struct Identity {
    /// The certificate in PEM format, followed by its intermediate certificates.
    pub certificate: Vec<u8>,
    /// Its private key in PEM format, not encrypted.
    pub key: Vec<u8>,
}

/// Settings of a client. Their debug text has no value of a header and no key.
#[derive(Clone)]
pub struct Settings {
    /// Address of the server.
    pub address: Address,
    /// Name of the instance on the server; often empty.
    pub instance: String,
    /// Headers of every request, for instance `authorization`.
    pub headers: Vec<(String, String)>,
    /// Certificate authorities to trust, in PEM format; `None`: the system's.
    pub certificates: Option<Vec<u8>>,
    /// This client's certificate.
    pub identity: Option<Identity>,
    /// Maximum time for one request and its answer.
    pub request_timeout: Duration,
    /// Maximum time for an action, from the request to its result, with all its retries.
    pub action_timeout: Duration,
    /// Maximum number of attempts for one request.
    pub attempts: u32,
}

impl Settings {
    /// The usual settings for a server.
    pub fn new(address: Address) -> Self {
        Self {
            address,
            instance: String::new(),
            headers: Vec::new(),
            certificates: None,
            identity: None,
            request_timeout: Duration::from_secs(60),
            action_timeout: Duration::from_secs(3600),
            attempts: 5,
        }
    }
}

impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Identity").finish_non_exhaustive()
    }
}

impl fmt::Debug for Settings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let headers: Vec<&str> = self.headers.iter().map(|(name, _)| name.as_str()).collect();
        f.debug_struct("Settings")
            .field("address", &self.address)
            .field("instance", &self.instance)
            .field("headers", &headers)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn debug_texts_have_no_secrets() {
        let mut settings = Settings::new("grpc://a:1".parse().unwrap());
        settings.headers.push(("authorization".to_owned(), "Bearer secret".to_owned()));
        settings.identity = Some(Identity { certificate: b"secret".to_vec(), key: b"secret".to_vec() });
        let text = format!("{settings:?} {:?}", settings.identity);
        assert!(text.contains("authorization") && !text.contains("secret") && !text.contains("115, 101"), "{text}");
    }

    #[test]
    fn addresses_are_read_and_written() {
        for text in ["grpc://127.0.0.1:50051", "grpcs://farm.example:443", "grpc://[::1]:8980"] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
        for text in
            ["", "grpc://", "grpc://host", "grpc://:1", "grpc://a:99999", "grpc://user@a:1", "grpc://a/b:1", "unix:x"]
        {
            assert!(text.parse::<Address>().is_err(), "{text}");
        }
    }
}
