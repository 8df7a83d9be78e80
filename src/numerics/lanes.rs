//! One kernel, every instruction set: the same source compiled for SSE2, AVX2 and AVX-512, chosen by CPU at run time.
//!
//! A kernel is written once on arrays `[f64; L]` with plain loops; the compiler turns them into whatever vectors the
//! level has. Rust neither contracts nor reorders `+ - * /` and `sqrt`, so every level gives the same bits.
//! The environment variable `ENCOUNTER_LEVEL=base|avx2|avx512` forces a level in tests; it cannot change a result.

use std::sync::OnceLock;

/// A computation to be compiled once per [`Level`].
///
/// Mark `run` `#[inline(always)]`, or it is compiled for the base level alone.
pub trait Kernel {
    /// What the computation returns.
    type Output;
    /// Runs the computation.
    fn run(self) -> Self::Output;
}

/// An instruction-set level of the CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// What every CPU of the architecture has (SSE2 on x86-64, NEON on aarch64).
    Base,
    /// 256-bit vectors.
    Avx2,
    /// 512-bit vectors.
    Avx512,
}

impl Level {
    /// The word for this level, in `ENCOUNTER_LEVEL` and in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// The highest level this CPU has.
    #[cfg(target_arch = "x86_64")]
    pub fn available() -> Self {
        let avx512 = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq");
        match (avx512, is_x86_feature_detected!("avx2")) {
            (true, true) => Self::Avx512,
            (false, true) => Self::Avx2,
            _ => Self::Base,
        }
    }

    /// The highest level this CPU has.
    #[cfg(not(target_arch = "x86_64"))]
    pub fn available() -> Self {
        Self::Base
    }

    /// The level in force: the one forced by `ENCOUNTER_LEVEL`, else the highest available.
    ///
    /// # Errors
    /// A word that is no level, or a level that this CPU lacks.
    pub fn choose(forced: Option<&str>) -> Result<Self, String> {
        let available = Self::available();
        let Some(word) = forced else {
            return Ok(available);
        };
        let level = [Self::Base, Self::Avx2, Self::Avx512]
            .into_iter()
            .find(|level| level.name() == word)
            .ok_or_else(|| format!("ENCOUNTER_LEVEL: expected base, avx2 or avx512, found `{word}`"))?;
        if level > available {
            return Err(format!(
                "ENCOUNTER_LEVEL: this CPU has no {word}, only {}",
                available.name()
            ));
        }
        Ok(level)
    }

    /// The level in force, decided once.
    pub fn current() -> Self {
        static LEVEL: OnceLock<Level> = OnceLock::new();
        *LEVEL.get_or_init(|| {
            let forced = std::env::var("ENCOUNTER_LEVEL").ok();
            Self::choose(forced.as_deref()).unwrap_or_else(|_| Self::available())
        })
    }
}

/// Runs a kernel with the vectors of the [`Level`] in force.
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    dispatch_at(Level::current(), kernel)
}

/// Runs a kernel with the vectors of one level, or of the highest available below it.
#[cfg_attr(
    target_arch = "x86_64",
    expect(
        unsafe_code,
        reason = "a function with target features may run only where the CPU has them"
    )
)]
pub fn dispatch_at<K: Kernel>(level: Level, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a level is used only if `available` found its features on this CPU.
    unsafe {
        match level.min(Level::available()) {
            Level::Avx512 => avx512(kernel),
            Level::Avx2 => avx2(kernel),
            Level::Base => kernel.run(),
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = level;
        kernel.run()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
