//! No helper of the vector kernels may stand in the program as a function of its own: out of line it would be compiled
//! without the instruction set of its caller, and every intrinsic in it would become a call. That cost up to five times
//! the time (a closure over vectors: 501 against 108 ns a ray). What may stand there are the entry points, one an
//! instruction set, which end in its name: `traverse_avx2`.

/// Modules, types and functions that must be inlined completely, as they stand in symbols of either mangling.
const KERNELS: [&[&str]; 11] = [
    &["bvh", "simd"],
    &["bvh", "kernels"],
    // And `plain_packets`.
    &["bvh", "packets"],
    &["bvh", "packet_rows"],
    &["bvh", "triangles", "Test"],
    &["geometry", "slab"],
    &["scene", "body"],
    &["scene", "front"],
    &["scene", "through", "passage"],
    &["scene", "surface", "Placement"],
    &["geometry", "triangle", "TriangleRay"],
];

/// What of it may be called: methods of the tree, which choose the entry point, the entry points, and what runs once
/// and not for every ray.
const CALLED: [&str; 7] = ["glimt..bvh..Bvh$GT$", "_avx2", "_avx512", "_portable", "3Isa", "simd..Isa", "4simd6buffer"];

/// Functions that should have been inlined.
fn strays<'a>(symbols: &[&'a str]) -> Vec<&'a str> {
    let in_order = |symbol: &str, words: &[&str]| {
        let mut rest = symbol;
        words.iter().all(|word| match rest.find(word) {
            Some(at) => {
                rest = &rest[at + word.len()..];
                true
            }
            None => false,
        })
    };
    let is_stray = |symbol: &str| {
        let called = CALLED.iter().any(|word| symbol.contains(word));
        // What the standard library is called with and is no function of glimt.
        let generic = ["_ZN4core", "_ZN5alloc", "_ZN3std"].iter().any(|library| symbol.starts_with(library));
        let kernel =
            symbol.contains("glimt") && !generic && KERNELS.iter().any(|words| in_order(symbol, words)) && !called;
        kernel || (symbol.contains("core_arch") && symbol.contains("_mm"))
    };
    symbols.iter().copied().filter(|symbol| is_stray(symbol)).collect()
}

#[test]
fn functions_that_fell_out_of_line_are_found() {
    for stray in [
        "_ZN4core9core_arch3x863avx13_mm256_mul_ps17h0123456789abcdefE",
        "_RNvNtNtNtCs1_4core9core_arch3x863fma15__mm256_fmadd_ps",
        "_ZN84_$LT$glimt..bvh..simd..x86..Avx2$u20$as$u20$glimt..bvh..simd..Lanes$GT$3mul17h0123456789abcdefE",
        "_ZN5glimt3bvh4simd4slab18SlabLanes$LT$L$GT$7entries28_$u7b$$u7b$closure$u7d$$u7d$17h0123456789abcdefE",
        "_ZN5glimt3bvh4simd8traverse8traverse17h0123456789abcdefE",
        "_ZN85_$LT$glimt..bvh..triangles..WatertightTest$u20$as$u20$glimt..bvh..triangles..BlockTest$GT$3new17h0E",
        "_ZN97_$LT$glimt..scene..leaf..AnyObject$LT$F$GT$$u20$as$u20$glimt..bvh..simd..traverse..LeafVisitor$GT$5visit17h0E",
        "_RINvXs_NtNtCs1_5glimt3bvh9trianglesNtB5_14WatertightTestNtB5_9BlockTest10candidates",
        "_ZN5glimt8geometry8triangle11TriangleRay3new17h0123456789abcdefE",
    ] {
        assert_eq!(strays(&[stray]), [stray]);
    }
    for called in [
        "_ZN5glimt3bvh4simd8traverse13traverse_avx217h0123456789abcdefE",
        "_RINvNtNtNtCs1_5glimt3bvh4simd8traverse15traverse_avx512NtB4_1X",
        "_ZN5glimt3bvh4simd3Isa12is_available17h0123456789abcdefE",
        "_ZN5glimt3bvh9triangles9Triangles5build17h0123456789abcdefE",
        "_RNvNtNtNtCs1_4core9core_arch3x865xsave7__xgetbv",
        "_ZN4core3ptr52drop_in_place$LT$alloc..vec..Vec$LT$glimt..bvh..simd..x86..Avx2$GT$$GT$17h0123456789abcdefE",
    ] {
        assert_eq!(strays(&[called]), [""; 0]);
    }
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn the_vector_kernels_of_the_program_are_inlined_completely() {
    let program = std::fs::read(env!("CARGO_BIN_EXE_glimt")).unwrap();
    let symbols = elf_functions(&program);
    if symbols.is_empty() {
        return println!("skipped: the program is stripped, so that its functions have no names");
    }
    for entry in ["traverse_avx2", "packet_avx2", "packet_avx512", "run_avx2", "run_avx512"] {
        assert!(symbols.iter().any(|symbol| symbol.contains(entry)), "there is no {entry}: what is it called now?");
    }
    let strays = strays(&symbols);
    assert!(strays.is_empty(), "out of line, so without their instruction set:\n{}", strays.join("\n"));
}

/// Names of all functions in a 64-bit little-endian ELF file.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn elf_functions(file: &[u8]) -> Vec<&str> {
    fn number<const N: usize>(bytes: &[u8], at: usize) -> usize {
        bytes[at..at + N].iter().rev().fold(0, |n, byte| n << 8 | usize::from(*byte))
    }
    assert_eq!(&file[..6], b"\x7fELF\x02\x01");
    let (table, size, count) = (number::<8>(file, 40), number::<2>(file, 58), number::<2>(file, 60));
    let section = |index: usize| &file[table + index * size..][..size];
    let content = |section: &[u8]| &file[number::<8>(section, 24)..][..number::<8>(section, 32)];
    let symbol_tables = (0..count).map(section).filter(|section| number::<4>(section, 4) == 2);
    let mut names = Vec::new();
    for symbols in symbol_tables {
        let strings = content(section(number::<4>(symbols, 40)));
        // The low four bits of the fifth byte are the kind; 2 is a function.
        for symbol in content(symbols).chunks_exact(24).filter(|symbol| symbol[4] & 15 == 2) {
            let name = strings[number::<4>(symbol, 0)..].split(|byte| *byte == 0).next().unwrap();
            names.push(std::str::from_utf8(name).unwrap());
        }
    }
    names
}
