/* What C makes of the truth: eight fields and three epsilon_1, in loops over lanes for the compiler to do its best.

   rk4    ns of a lane-step: 24 lanes of the roll equation by RK4, 16,384 steps; the best of 100 runs
   truth  the same from phases to the largest roll in groups: see truth() below
          no argument: the peak, in GFlop/s, of multiplications and additions that do not wait for each other */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LANES = 24, COLUMNS = 8, STEPS = 16384 };

static double eta[2 * STEPS + 1][COLUMNS], epsilon_1[LANES], theta[LANES], theta_dot[LANES];

#define INLINE static inline __attribute__((always_inline))

INLINE double acceleration(double x, double v, double e, double eta) {
    double damping = (0.01 + 0.052 * (v * v)) * v;
    double restoring = (0.1175 + e * eta - 0.09 * (x * x)) * x;
    return 0.004 * eta - damping - restoring;
}

INLINE void step(const double (*eta)[COLUMNS], double *theta, double *theta_dot, const double *epsilon_1) {
    const double h = 15.0 / 64.0;
#pragma omp simd
    for (int i = 0; i < COLUMNS; i++) {
        double x = theta[i], v = theta_dot[i], e = epsilon_1[i];
        double k1 = acceleration(x, v, e, eta[0][i]);
        double v2 = v + 0.5 * h * k1;
        double k2 = acceleration(x + 0.5 * h * v, v2, e, eta[1][i]);
        double v3 = v + 0.5 * h * k2;
        double k3 = acceleration(x + 0.5 * h * v2, v3, e, eta[1][i]);
        double v4 = v + h * k3;
        double k4 = acceleration(x + h * v3, v4, e, eta[2][i]);
        theta[i] = x + h / 6.0 * (v + 2.0 * (v2 + v3) + v4);
        theta_dot[i] = v + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
    }
}

static void rk4(void) {
    for (int k = 0; k < STEPS; k++)
        for (int first = 0; first < LANES; first += COLUMNS)
            step(&eta[2 * k], theta + first, theta_dot + first, epsilon_1 + first);
}

/* Modes to series: a field's 32,768 samples are 32 transforms of its 1,024 modes, each turned by a shift. Radix 4 that
   sorts itself, eight fields to a vector. */
enum { N = 1024, SHIFTS = 2 * STEPS / N };
typedef struct { double re[COLUMNS], im[COLUMNS]; } wide;
typedef struct { double re, im; } number;

static wide spectrum[N], buffer[2][N];
static number turns[2 * STEPS];
static double phase[COLUMNS][N], amplitude[N];

static void pass(const wide *from, wide *to, int n, int stride) {
    int quarter = n / 4;
    for (int p = 0; p < quarter; p++) {
        number w1 = turns[SHIFTS * stride * p], w2 = turns[2 * SHIFTS * stride * p], w3 = turns[3 * SHIFTS * stride * p];
        for (int q = 0; q < stride; q++) {
            const wide *a = &from[q + stride * p], *b = a + stride * quarter, *c = b + stride * quarter,
                       *d = c + stride * quarter;
            wide *out = &to[q + 4 * stride * p];
#pragma omp simd
            for (int i = 0; i < COLUMNS; i++) {
                double sr = a->re[i] + c->re[i], si = a->im[i] + c->im[i], gr = a->re[i] - c->re[i],
                       gi = a->im[i] - c->im[i], tr = b->re[i] + d->re[i], ti = b->im[i] + d->im[i],
                       hr = b->re[i] - d->re[i], hi = b->im[i] - d->im[i];
                double xr = gr - hi, xi = gi + hr, yr = sr - tr, yi = si - ti, zr = gr + hi, zi = gi - hr;
                out[0].re[i] = sr + tr;
                out[0].im[i] = si + ti;
                out[stride].re[i] = xr * w1.re - xi * w1.im;
                out[stride].im[i] = xr * w1.im + xi * w1.re;
                out[2 * stride].re[i] = yr * w2.re - yi * w2.im;
                out[2 * stride].im[i] = yr * w2.im + yi * w2.re;
                out[3 * stride].re[i] = zr * w3.re - zi * w3.im;
                out[3 * stride].im[i] = zr * w3.im + zi * w3.re;
            }
        }
    }
}

static void synthesis(void) {
    for (int k = 0; k < N; k++)
        for (int i = 0; i < COLUMNS; i++) {
            spectrum[k].re[i] = amplitude[k] * cos(phase[i][k]);
            spectrum[k].im[i] = amplitude[k] * sin(phase[i][k]);
        }
    for (int r = 0; r < SHIFTS; r++) {
        for (int k = 0; k < N; k++) {
            /* Mode k + 1 goes to its bin. */
            number w = turns[(k + 1) * r % (2 * STEPS)];
            wide *bin = &buffer[0][(k + 1) % N];
#pragma omp simd
            for (int i = 0; i < COLUMNS; i++) {
                bin->re[i] = spectrum[k].re[i] * w.re - spectrum[k].im[i] * w.im;
                bin->im[i] = spectrum[k].re[i] * w.im + spectrum[k].im[i] * w.re;
            }
        }
        int at = 0;
        for (int n = N, stride = 1; n > 1; n /= 4, stride *= 4, at = !at) pass(buffer[at], buffer[!at], n, stride);
        for (int q = 0; q < N; q++) memcpy(eta[r + SHIFTS * q], buffer[at][q].re, sizeof eta[0]);
    }
    memcpy(eta[2 * STEPS], eta[0], sizeof eta[0]);
}

/* From phases to the largest roll in seven groups a field: a lead-in and a field, a restart at rest at every capsize, steps
   above a level counted, the largest roll of every sixteen steps kept. No peak between steps, no share of time at other
   levels, no group that starts off a sixteenth step: less than the program does. */
enum { LEAD_IN = 2134, BLOCK = 16, BLOCKS = STEPS / BLOCK, GROUPS = 7 };
static double top[BLOCKS][LANES], above[LANES], capsizes[LANES], r[LANES][GROUPS];

INLINE void roll(int k, double *highest) {
    for (int first = 0; first < LANES; first += COLUMNS) {
        step(&eta[2 * k], theta + first, theta_dot + first, epsilon_1 + first);
#pragma omp simd
        for (int i = first; i < first + COLUMNS; i++) {
            double angle = fabs(theta[i]);
            int upright = angle <= 1.5707963267948966;
            angle = upright ? angle : 1.5707963267948966;
            theta[i] = upright ? theta[i] : 0.0;
            theta_dot[i] = upright ? theta_dot[i] : 0.0;
            capsizes[i] += upright ? 0.0 : 1.0;
            above[i] += angle > 0.7 ? 1.0 : 0.0;
            highest[i] = angle > highest[i] ? angle : highest[i];
        }
    }
}

static void truth(void) {
    synthesis();
    memset(theta, 0, sizeof theta);
    memset(theta_dot, 0, sizeof theta_dot);
    double unseen[LANES] = {0};
    for (int k = STEPS - LEAD_IN; k < STEPS; k++) roll(k, unseen);
    for (int b = 0; b < BLOCKS; b++) {
        memset(top[b], 0, sizeof top[b]);
        for (int k = 0; k < BLOCK; k++) roll(BLOCK * b + k, top[b]);
    }
    for (int i = 0; i < LANES; i++)
        for (int g = 0; g < GROUPS; g++) {
            r[i][g] = 0.0;
            for (int b = g * BLOCKS / GROUPS; b < (g + 1) * BLOCKS / GROUPS; b++)
                r[i][g] = top[b][i] > r[i][g] ? top[b][i] : r[i][g];
        }
}

/* A sea of 12 m about mode 256, a field to a column. */
static void prepare(void) {
    for (int j = 0; j < 2 * STEPS; j++)
        turns[j] = (number){cos(6.283185307179586 * j / (2 * STEPS)), sin(6.283185307179586 * j / (2 * STEPS))};
    unsigned long state = 1;
    double variance = 0.0;
    for (int k = 0; k < N; k++) {
        double off = (k + 1 - 256) / (256 * 0.02 / 0.4189);
        amplitude[k] = exp(-0.25 * off * off);
        variance += 0.5 * amplitude[k] * amplitude[k];
        for (int i = 0; i < COLUMNS; i++) {
            state = state * 6364136223846793005 + 1442695040888963407;
            phase[i][k] = 6.283185307179586 * (double)(state >> 11) / 9007199254740992.0;
        }
    }
    for (int k = 0; k < N; k++) amplitude[k] *= 3.0 / sqrt(variance);
}

/* As many chains of each as the registers hold: the units wait for no result. */
#if defined(__AVX512F__)
enum { WIDE = 8, CHAINS = 8 };
#elif defined(__AVX__)
enum { WIDE = 4, CHAINS = 7 };
#else
enum { WIDE = 2, CHAINS = 7 };
#endif
typedef double vector __attribute__((vector_size(8 * WIDE)));

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double peak(void) {
    enum { ROUNDS = 1000000 };
    vector by = (vector){0} + (1.0 - 1e-9), plus = (vector){0} + 1e-9, all = {0};
    vector product[CHAINS], sum[CHAINS];
    for (int c = 0; c < CHAINS; c++) product[c] = sum[c] = by + (double)c;
    double start = now();
    for (int n = 0; n < ROUNDS; n++)
#pragma GCC unroll 8
        for (int c = 0; c < CHAINS; c++) product[c] *= by, sum[c] += plus;
    double seconds = now() - start;
    for (int c = 0; c < CHAINS; c++) all += product[c] + sum[c];
    theta[0] = all[0];
    return 2e-9 * ROUNDS * CHAINS * WIDE / seconds;
}

int main(int count, char **words) {
    if (count < 2) {
        double best = 0.0;
        for (int n = 0; n < 30; n++) {
            double found = peak();
            best = found > best ? found : best;
        }
        printf("%.1f\n", best);
        return theta[0] < 0.0;
    }
    for (int j = 0; j <= 2 * STEPS; j++)
        for (int c = 0; c < COLUMNS; c++) eta[j][c] = 0.5;
    for (int i = 0; i < LANES; i++) epsilon_1[i] = 0.01 * (1 + i / COLUMNS);
    int whole = !strcmp(words[1], "truth");
    prepare();
    double best = 1e9;
    for (int n = 0; n < 100; n++) {
        double start = now();
        whole ? truth() : rk4();
        double seconds = now() - start;
        best = seconds < best ? seconds : best;
    }
    fprintf(stderr, "%.17g %.17g\n", theta[3] + theta_dot[5], r[9][3] + above[9] + capsizes[23]);
    printf("%.4f\n", 1e9 * best / LANES / (whole ? LEAD_IN + STEPS : STEPS));
}
