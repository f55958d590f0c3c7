//! A painted frame as a message.

use flaneur_proto::v1;
use tokio::time::Instant;
use tonic::Status;

use super::stage::Painted;
use crate::grpc::MAX_MESSAGE_BYTES;
use crate::shares::Shares;

/// Quality of JPEG of a frame that stays.
pub(super) const FINAL_QUALITY: u8 = 90;

/// A frame's message; its number and what is known of the stream are for the caller to fill in.
pub(super) struct Encoded {
    pub(super) message: v1::Frame,
    /// When its view came.
    pub(super) since: Instant,
}

/// The message of a frame, off the async threads. Where nobody chose another, a JPEG that will be
/// followed by a better one has the quality `passing`.
///
/// # Errors
/// Where the picture's file does not fit into a message, or the format cannot hold the picture.
pub(super) async fn encoded(painted: Painted, passing: u8) -> Result<Encoded, Status> {
    let encode = move || {
        let began = Instant::now();
        let Painted { frame, wanted, wish, finished, took, .. } = painted;
        let format = wish.format(if finished { FINAL_QUALITY } else { passing });
        let shares = Shares::of(&frame.stats);
        let image = format.encode(&frame).map_err(|e| Status::out_of_range(e.to_string()))?;
        if image.len() > MAX_MESSAGE_BYTES {
            let problem = format!(
                "the picture takes {} bytes, a message {MAX_MESSAGE_BYTES} at most: ask for JPEG, or \
                 for a smaller one",
                image.len()
            );
            return Err(Status::out_of_range(problem));
        }
        let message = v1::Frame {
            sequence: wanted.sequence,
            view: Some(wanted.message),
            media_type: format.media_type().to_owned(),
            image: image.into(),
            r#final: finished,
            render_ms: took.as_secs_f64() * 1e3,
            unsurveyed_share: shares.unsurveyed,
            blank_share: shares.blank,
            encode_ms: began.elapsed().as_secs_f64() * 1e3,
            ..v1::Frame::default()
        };
        Ok(Encoded { message, since: wanted.since })
    };
    let failed = |_| Status::internal("the picture could not be encoded");
    tokio::task::spawn_blocking(encode).await.map_err(failed)?
}
