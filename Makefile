# make demo   sets up what is missing, builds, makes a synthetic street, ingests it, serves it,
#             renders a frame through the service, and serves until Ctrl-C (ONCE=1: ends by itself)
# make test   sets up what is missing and runs every check and test

LISTEN ?= 127.0.0.1:7878
DEMO := target/demo
FLANEUR := target/release/flaneur

.PHONY: demo test setup

setup:
	@deploy/setup-debian.sh

demo: setup
	cargo build --release --locked
	@deploy/demo.sh $(FLANEUR) $(DEMO) $(LISTEN) $(ONCE)

test:
	@deploy/setup-debian.sh test
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --document-private-items --locked --quiet
	cargo test --workspace --locked
