//! Strips a response header that makes tonic panic from the answers of a server.
//!
//! tonic panics if `grpc-status-details-bin` is not Base64, and any server can send that. No caller
//! needs the header, so it is removed before tonic reads it: from headers, and from the trailers
//! that follow a body.

use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll};

use http_body_util::BodyExt as _;
use tonic::body::Body;
use tonic::codegen::{Service, http};
use tonic::transport::Channel;

/// Details of a status, in Base64.
const DETAILS: &str = "grpc-status-details-bin";

/// A channel whose answers have no [`DETAILS`].
#[derive(Clone, Debug)]
pub(crate) struct StripHeader(pub Channel);

impl Service<http::Request<Body>> for StripHeader {
    type Response = http::Response<Body>;
    type Error = tonic::transport::Error;
    type Future = Pin<Box<dyn Future<Output = Result<Self::Response, Self::Error>> + Send>>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Self::Error>> {
        self.0.poll_ready(context)
    }

    fn call(&mut self, request: http::Request<Body>) -> Self::Future {
        let answer = self.0.call(request);
        Box::pin(async move {
            let mut answer = answer.await?;
            answer.headers_mut().remove(DETAILS);
            Ok(answer.map(|body| {
                Body::new(body.map_frame(|mut frame| {
                    if let Some(trailers) = frame.trailers_mut() {
                        trailers.remove(DETAILS);
                    }
                    frame
                }))
            }))
        })
    }
}
