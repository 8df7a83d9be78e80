# All logic is in the binary and in cargo. What the verbs do: `cargo run --release -- help`.
CARGO := $(shell command -v cargo)
$(if $(CARGO),,$(error cargo not found: install the Rust toolchain from https://rustup.rs, then run make again))

.PHONY: figures quick tiny calibration test verify verify-cpus compare bench clean

figures: ; cargo run --release -- run
quick:   ; cargo run --release -- run --profile quick
tiny:    ; cargo run --release -- run --profile tiny
calibration: ; cargo run --release -- run calibration
test:    ; cargo test --release
verify:  ; cargo run --release -- verify --lock && cargo run --release -- verify --lock calibration
verify-cpus: ; tests/verify_cpus.sh
compare: ; cargo build --release && tests/compare/run
bench:   ; cargo bench
clean:   ; test ! -d artifacts || find artifacts -mindepth 1 -maxdepth 1 \( ! -name '*.lock' -o -name store.lock \) -exec rm -rf {} +
