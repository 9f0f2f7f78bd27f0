/* CORDIC units and single-precision operators by hand: loops over blocks that stay in the nearest cache.

   The yardstick of benchmarks/emulator.py, which writes constants.h and the calls of a plan's operations.
   Operands of at most 2^19 in magnitude; what is invalid becomes nan, and infinities stay. */
#include <math.h>
#include <stdint.h>
#include <string.h>
#include "constants.h"

static int64_t a[BLOCK], b[BLOCK], c[BLOCK], t[BLOCK], z[BLOCK], ae[BLOCK], be[BLOCK], ce[BLOCK], e[BLOCK];

static inline int64_t unpack(float v, int64_t *exponent)
{
    int64_t bits;
    double d = v;
    memcpy(&bits, &d, 8);
    int64_t zero = -(d == 0), s = bits >> 63;
    *exponent = ((((bits >> 52) & 0x7ff) - 1022 - 24) & ~zero) | (-4096 & zero);
    return ((((bits & 0xfffffffffffff) | 0x10000000000000) >> 29 ^ s) - s) & ~zero;
}

static inline int64_t shifted(int64_t m, int64_t right)
{
    int64_t left = right < 0 ? -right : 0, count = right > 0 ? right : 0;
    if (left > 62) left = 62;
    if (count > 62) count = 62;
    return ((int64_t)((uint64_t)m << left) + ((INT64_C(1) << count) >> 1)) >> count;
}

static inline double power(int64_t exponent)
{
    if (exponent < -1022) exponent = -1022;
    if (exponent > 1023) exponent = 1023;
    int64_t bits = (exponent + 1023) << 52;
    double d;
    memcpy(&d, &bits, 8);
    return d;
}

static inline float angle_word(double angle)
{
    const float pi = 3.14159250259399414f;
    float word = (float)angle;
    return word > pi && angle <= PI_LIMIT ? pi : word < -pi && angle >= -PI_LIMIT ? -pi : word;
}

static inline int64_t compensated(int64_t v)
{
    int64_t carry = (v & 7) * GAIN + (INT64_C(1) << (GAIN_SHIFT - 1));
    return ((v >> 3) * GAIN + (carry >> 3)) >> (GAIN_SHIFT - 3);
}

static void vector(const float *x, const float *y, const float *addend, int sign, float *norm, float *angle, int n)
{
    for (int i = 0; i < n; i++) a[i] = unpack(x[i], &ae[i]);
    for (int i = 0; i < n; i++) b[i] = unpack(y[i], &be[i]);
    for (int i = 0; i < n; i++) e[i] = (ae[i] > be[i] ? ae[i] : be[i]) - ROOM;
    for (int i = 0; i < n; i++) {
        int64_t side = a[i] >> 63, up = b[i] >> 63;
        z[i] = ((HALF_TURN ^ up) - up) & side;
        a[i] = (shifted(a[i], e[i] - ae[i]) ^ side) - side;
        b[i] = (shifted(b[i], e[i] - be[i]) ^ side) - side;
    }
    for (int step = 0; step < VECTOR_STEPS; step++) {
        int64_t half = (INT64_C(1) << step) >> 1, turn = ANGLES[step];
        for (int i = 0; i < n; i++) {
            int64_t mask = b[i] >> 63, by = (b[i] + half) >> step;
            b[i] -= (((a[i] + half) >> step) ^ mask) - mask;
            a[i] += by < 0 ? -by : by;
            z[i] += (turn ^ mask) - mask;
        }
    }
    for (int i = 0; i < n; i++) norm[i] = (float)((double)compensated(a[i]) * power(e[i] - SCALE_BITS));
    for (int i = 0; i < n; i++) {
        int64_t least = y[i] >= 0 ? 0 : -HALF_TURN, most = y[i] > 0 || x[i] < 0 ? HALF_TURN : 0;
        int64_t sum = z[i] < least ? least : z[i];
        sum = sum > most ? most : sum;
        sum = sign * sum + (int64_t)floor((double)addend[i] * ANGLE_SCALE + 0.5);
        float word = angle_word((double)sum * (1 / ANGLE_SCALE));
        angle[i] = (x[i] == 0 && y[i] == 0) || x[i] != x[i] || y[i] != y[i] ? NAN : word;
    }
}

#ifdef IMPLICIT_STEPS
static void implicit(const float *A, const float *B, const float *C, int sign, float *angle, float *rest, int n)
{
    for (int i = 0; i < n; i++) a[i] = unpack(A[i], &ae[i]);
    for (int i = 0; i < n; i++) b[i] = unpack(B[i], &be[i]);
    for (int i = 0; i < n; i++) t[i] = unpack(C[i], &ce[i]);
    for (int i = 0; i < n; i++) {
        int64_t most = ae[i] > be[i] ? ae[i] : be[i];
        e[i] = (most > ce[i] ? most : ce[i]) - ROOM;
    }
    for (int i = 0; i < n; i++) {
        int64_t side = -(int64_t)(sign > 0 ? (A[i] > 0) | ((A[i] == 0) & (B[i] < 0)) : A[i] < 0);
        int64_t x = -sign * ((shifted(a[i], e[i] - ae[i]) ^ side) - side);
        int64_t y = (shifted(b[i], e[i] - be[i]) ^ side) - side;
        t[i] = shifted(t[i], e[i] - ce[i]);
        int64_t apart = (t[i] ^ y) >> 63, down = t[i] >> 63;
        a[i] = ((((-y ^ down) - down) & apart)) | (x & ~apart);
        b[i] = (((x ^ down) - down) & apart) | (y & ~apart);
        z[i] = (-HALF_TURN & side) + (((((HALF_TURN + 1) >> 1) ^ down) - down) & apart);
    }
    for (int step = 0; step < IMPLICIT_STEPS; step++) {
        int64_t half = (INT64_C(1) << step) >> 1, turn = ANGLES[step], growth = GROWTH[step];
        for (int i = 0; i < n; i++) {
            int64_t mask = (a[i] < 0 ? ~b[i] : t[i] - b[i]) >> 63;
            int64_t x = (((b[i] + half) >> step) ^ mask) - mask;
            b[i] += (((a[i] + half) >> step) ^ mask) - mask;
            a[i] -= x;
            z[i] += (turn ^ mask) - mask;
        }
        if (growth >> 29)
            for (int i = 0; i < n; i++) {
                int64_t low = (t[i] & 0xffff) * growth + (INT64_C(1) << (FACTOR_BITS - 1));
                t[i] += ((t[i] >> 16) * growth + (low >> 16)) >> (FACTOR_BITS - 16);
            }
        else if (growth)
            for (int i = 0; i < n; i++) t[i] += (t[i] * growth + (INT64_C(1) << (FACTOR_BITS - 1))) >> FACTOR_BITS;
    }
    for (int i = 0; i < n; i++) {
        int one_sided = (A[i] == 0) & (B[i] > 0);
        int64_t least = one_sided ? -HALF_TURN : -2 * HALF_TURN, most = one_sided ? 0 : 2 * HALF_TURN;
        int64_t turned = z[i] < least ? least : z[i], off = b[i] - t[i];
        turned = -sign * (turned > most ? most : turned);
        int solved = (off < 0 ? -off : off) <= TOLERANCE && (A[i] != 0 || B[i] != 0) && A[i] + B[i] + C[i] == A[i] + B[i] + C[i];
        angle[i] = solved ? angle_word((double)turned * (1 / ANGLE_SCALE)) : NAN;
        rest[i] = solved ? (float)((double)compensated(a[i] < 0 ? 0 : a[i]) * power(e[i] - SCALE_BITS)) : NAN;
    }
}
#endif

static inline void add(const float *x, const float *y, float *out, int n)
{
    for (int i = 0; i < n; i++) out[i] = x[i] + y[i];
}

static inline void sub(const float *x, const float *y, float *out, int n)
{
    for (int i = 0; i < n; i++) out[i] = x[i] - y[i];
}

static inline void mul(const float *x, const float *y, float *out, int n)
{
    for (int i = 0; i < n; i++) out[i] = x[i] * y[i];
}

static inline void neg(const float *x, float *out, int n)
{
    for (int i = 0; i < n; i++) out[i] = -x[i];
}

static inline void wrap(const float *x, float *out, int n)
{
    for (int i = 0; i < n; i++) {
        double turns = rint((double)x[i] / TAU);
        out[i] = angle_word(((double)x[i] - turns * TAU_HEAD) - turns * TAU_TAIL);
    }
}

#include "calls.h"
