//! §2: group detection.
