# make demo   sets up what is missing, builds, makes a synthetic street, ingests it, serves it,
#             renders a frame through the service, and serves until Ctrl-C (ONCE=1: ends by itself)
# make test   sets up what is missing and runs every check and test

LISTEN ?= 127.0.0.1:7878
DEMO := target/demo
FLANEUR := target/release/flaneur

# The web page, which the binary carries.
WEB := services/web
EXAMPLE := examples/typescript
PAGE := $(WEB)/dist/index.html
PAGE_SOURCES := $(shell find $(WEB)/src $(WEB)/public $(WEB)/build -path $(WEB)/src/gen -prune -o -type f -print) \
	$(wildcard $(WEB)/*.json $(WEB)/*.ts $(WEB)/*.yaml proto/proto/flaneur/v1/*.proto) $(WEB)/index.html

.PHONY: demo test setup web

setup:
	@deploy/setup-debian.sh

web: $(PAGE)

%/node_modules/.installed: %/package-lock.json | setup
	cd $* && npm ci --no-audit --no-fund
	touch $@

$(PAGE): $(WEB)/node_modules/.installed $(PAGE_SOURCES) | setup
	cd $(WEB) && npm run build

demo: setup web
	cargo build --release --locked
	@deploy/demo.sh $(FLANEUR) $(DEMO) $(LISTEN) $(ONCE)

test: web $(EXAMPLE)/node_modules/.installed
	@deploy/setup-debian.sh test
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --document-private-items --locked --quiet
	cargo test --workspace --locked
	cd $(WEB) && npm run check
	cd $(EXAMPLE) && npm run check
	cd $(WEB) && FLANEUR=$(CURDIR)/target/debug/flaneur npm run test:e2e
