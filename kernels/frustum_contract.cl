// Contraction of a form, by terms of SCALAR in lanes of LANES: once in a kernel's own reals, and where it refines roots once in doubles.

// With a row, once for all lanes: [depth][across].
static inline void CONTRACTION(row)(__global const SCALAR* form, int row, __global const SCALAR* polynomials, int down, int count, SCALAR* plane) {
  for (int first = 0; first < count; first += W) {
    LANES sum = (LANES)0;
    for (int j = 0; j < down; ++j) sum = fma(LOAD(form + j * count + first), (LANES)polynomials[j * IRT_TILE + row], sum);
    STORE(sum, plane + first);
  }
}

// And with the columns: coefficients along the rays of a packet.
static inline void CONTRACTION(columns)(const SCALAR* plane, int column, __global const SCALAR* polynomials, int across, LANES* c) {
  for (int first = 0; first < TERMS; first += SUMS(TERMS)) {
    LANES sums[SUMS(TERMS)];
    UNROLL(SUMS(TERMS)) for (int m = 0; m < SUMS(TERMS); ++m) sums[m] = (LANES)0;
    for (int i = 0; i < across; ++i) {
      const LANES weight = LOAD(polynomials + i * IRT_TILE + column);
      UNROLL(SUMS(TERMS)) for (int m = 0; m < SUMS(TERMS); ++m) sums[m] = fma((LANES)plane[min(first + m, TERMS - 1) * across + i], weight, sums[m]);
    }
    UNROLL(SUMS(TERMS)) for (int m = 0; m < SUMS(TERMS); ++m) c[min(first + m, TERMS - 1)] = sums[m];
  }
}

#undef SCALAR
#undef LANES
#undef TERMS
#undef CONTRACTION
