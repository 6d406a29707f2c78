// Every cap of the library in one place. Past a cap the answer is a LimitError that names it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace irt::limits {

// Distinct nodes of an expression that is evaluated, differentiated, expanded, simplified or handed to the reference; a model of thousands
// of operations fits many times over. Operators build more, and str, subs and pickle take it; programs have kOperations.
inline constexpr std::size_t kNodes = 200'000;
// Levels of parentheses, calls, roots and exponents in one another that `parse` accepts, which goes down into them by recursion: all of
// them take less than 256 KiB of stack (2.5 MiB under sanitizers), and threads may have 512. Trees built by operators may be deeper.
inline constexpr std::size_t kParseDepth = 128;
// Nesting depth of a tree that can be printed, which is done by recursion as well; all other walks are iterative.
inline constexpr int kPrintDepth = 1000;
// Characters of one formula handed to `parse`, and of one printed.
inline constexpr std::size_t kFormulaLength = 1 << 20;
// Characters of one identifier.
inline constexpr std::size_t kIdentifierLength = 64;
// Bits in the numerator or denominator of a number; larger powers of numbers stay unevaluated or are refused.
inline constexpr std::size_t kNumberBits = 1 << 16;
// Terms that `expand` may produce.
inline constexpr std::size_t kExpandTerms = 200'000;
// Pairs of terms that `expand` may multiply on the way: a quarter of a second's work.
inline constexpr std::size_t kExpandProducts = 1'000'000;
// Largest degree of a polynomial.
inline constexpr long kDegree = 1'000'000'000;
// Arguments, over all parts, that a derivative may have: those of deep chains grow with the square of the depth.
inline constexpr std::size_t kDerivativeArguments = 200'000;
// Largest |n| of an integer power that a kernel unrolls.
inline constexpr long kExponent = 1'000'000;
// Operations of one program: beyond this the OpenCL compilers need minutes.
inline constexpr std::size_t kOperations = 10'000;
// Bytes of one generated source.
inline constexpr std::size_t kSourceBytes = 8u << 20;
// Pixels of one frame (64 Mpx) and rays of one batch; Python knows them as _core.MAX_PIXELS and MAX_SIDE.
inline constexpr std::uint64_t kPixels = 1ull << 26;
// Pixels of one side of a frame.
inline constexpr std::uint64_t kSide = 1ull << 20;
// Degree up to which the reference makes polynomials along rays; above it works with ranges.
inline constexpr int kRayDegree = 200;
// Degree of the frustum form: (degree + 1)^3 coefficients a cell.
inline constexpr int kFrustumDegree = 32;
// Degree along a ray that closed forms solve, and polynomials under the set operations of one formula: their roots lie in private memory.
inline constexpr int kClosedDegree = 4;
inline constexpr std::size_t kLeaves = 64;
// Built programs that a device keeps.
inline constexpr std::size_t kPrograms = 64;
// Pieces of one ray, where the call says nothing; beyond this it is UNRESOLVED. Hard surfaces need some thousands; the hardest by
// intervals (sarti_12, expanded) 10^5 on few rays, and those are done in double.
inline constexpr int kPieces = 1 << 16, kPiecesInDouble = 1 << 18;
// Parameters of one formula.
inline constexpr std::size_t kParameters = 256;

}  // namespace irt::limits
