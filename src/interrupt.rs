//! Ctrl-C and SIGTERM.

use tokio_util::sync::CancellationToken;

/// A token that is cancelled at the first Ctrl-C or SIGTERM; a second one ends the process
/// at once with code 130.
pub(crate) fn on_ctrl_c() -> CancellationToken {
    let token = CancellationToken::new();
    let cancelled = token.clone();
    tokio::spawn(async move {
        signal().await;
        cancelled.cancel();
        signal().await;
        std::process::exit(130);
    });
    token
}

#[cfg(unix)]
async fn signal() {
    use tokio::signal::unix::{SignalKind, signal};
    match signal(SignalKind::terminate()) {
        Ok(mut terminate) => {
            tokio::select! {
                outcome = tokio::signal::ctrl_c() => wait_if_refused(outcome).await,
                _ = terminate.recv() => {}
            }
        }
        Err(_) => wait_if_refused(tokio::signal::ctrl_c().await).await,
    }
}

#[cfg(not(unix))]
async fn signal() {
    wait_if_refused(tokio::signal::ctrl_c().await).await;
}

/// Where the system gives no signals, none ever comes.
async fn wait_if_refused(outcome: std::io::Result<()>) {
    if let Err(error) = outcome {
        tracing::warn!(%error, "cannot listen for ctrl-c");
        std::future::pending::<()>().await;
    }
}
