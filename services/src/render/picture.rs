//! A painted frame as a message.

use flaneur_proto::v1;
use flaneur_renderer::FrameStats;
use tokio::time::Instant;
use tonic::Status;

use super::stage::Painted;
use crate::grpc::MAX_MESSAGE_BYTES;

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
        let [unsurveyed_share, blank_share] = shares_without(&frame.stats);
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
            unsurveyed_share,
            blank_share,
            encode_ms: began.elapsed().as_secs_f64() * 1e3,
            ..v1::Frame::default()
        };
        Ok(Encoded { message, since: wanted.since })
    };
    let failed = |_| Status::internal("the picture could not be encoded");
    tokio::task::spawn_blocking(encode).await.map_err(failed)?
}

/// The shares of a picture's pixels without geometry, and without anything at all.
fn shares_without(stats: &FrameStats) -> [f64; 2] {
    let unsurveyed = stats.pixels.saturating_sub(stats.geometry_pixels);
    let blank = unsurveyed.saturating_sub(stats.inferred_pixels + stats.completed_pixels);
    [unsurveyed, blank].map(|pixels| pixels as f64 / stats.pixels.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_inferred_is_not_surveyed_but_not_blank_either() {
        let stats = FrameStats {
            pixels: 100,
            geometry_pixels: 60,
            inferred_pixels: 20,
            completed_pixels: 10,
            ..FrameStats::default()
        };
        assert_eq!(shares_without(&stats), [0.4, 0.1]);
        assert_eq!(shares_without(&FrameStats::default()), [0.0, 0.0]);
    }
}
