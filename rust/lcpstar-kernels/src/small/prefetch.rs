//! The memory of the next problems, asked for while these are worked on.

use super::lane::MOST_LANES;

/// Bytes that memory hands over at once.
const LINE: usize = 64;

/// Blocks of memory that are needed soon. They are asked for a few lines at a time: a processor has room for some sixteen
/// requests, and waits at the next one.
#[derive(Default)]
pub struct Prefetch {
    /// Addresses of the blocks, at most one for every lane of a tile.
    starts: [usize; MOST_LANES],
    blocks: usize,
    /// Lines of a block.
    lines: usize,
    /// The line to ask for next.
    next: (usize, usize),
    /// Lines asked for in one step.
    at_once: usize,
}

impl Prefetch {
    /// Forgets what was planned.
    #[inline(always)]
    pub fn clear(&mut self) {
        (self.blocks, self.next) = (0, (0, 0));
    }

    /// Plans to ask for one more block, of as many numbers as the others, all within `steps` steps.
    #[inline(always)]
    pub fn plan<T>(&mut self, block: &[T], steps: usize) {
        self.starts[self.blocks] = block.as_ptr() as usize;
        self.blocks += 1;
        self.lines = size_of_val(block).div_ceil(LINE);
        self.at_once = (self.blocks * self.lines).div_ceil(steps);
    }

    /// Asks for some lines.
    #[inline(always)]
    pub fn step(&mut self) {
        self.ask(self.at_once);
    }

    /// Asks for what is left.
    #[inline(always)]
    pub fn rest(&mut self) {
        self.ask(usize::MAX);
    }

    #[inline(always)]
    fn ask(&mut self, mut lines: usize) {
        let (mut block, mut line) = self.next;
        while lines > 0 && block < self.blocks {
            let count = lines.min(self.lines - line);
            let first = self.starts[block] + line * LINE;
            for k in 0..count {
                ask_line(first + k * LINE);
            }
            (line, lines) = (line + count, lines - count);
            if line == self.lines {
                (block, line) = (block + 1, 0);
            }
        }
        self.next = (block, line);
    }
}

/// Changes nothing but the time.
#[inline(always)]
fn ask_line(address: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        #[allow(unsafe_code, reason = "an instruction that every x86-64 machine has and that touches nothing")]
        // SAFETY: no address can make it fail.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(address as *const i8);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}
