/* 24 lanes of the roll equation by RK4, for the compiler to do its best: 16,384 steps, as often as the argument says. */
#include <stdio.h>
#include <stdlib.h>

enum { LANES = 24, COLUMNS = 8, STEPS = 16384 };

static double eta[2 * STEPS + 1][COLUMNS], epsilon_1[LANES], theta[LANES], theta_dot[LANES];

static inline double acceleration(double x, double v, double e, double eta) {
    double damping = (0.01 + 0.052 * (v * v)) * v;
    double restoring = (0.1175 + e * eta - 0.09 * (x * x)) * x;
    return 0.004 * eta - damping - restoring;
}

static void step(const double (*eta)[COLUMNS], double *theta, double *theta_dot, const double *epsilon_1) {
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

static void run(void) {
    for (int k = 0; k < STEPS; k++)
        for (int first = 0; first < LANES; first += COLUMNS)
            step(&eta[2 * k], theta + first, theta_dot + first, epsilon_1 + first);
}

int main(int count, char **words) {
    for (int j = 0; j <= 2 * STEPS; j++)
        for (int c = 0; c < COLUMNS; c++) eta[j][c] = 0.5;
    for (int i = 0; i < LANES; i++) epsilon_1[i] = 0.02 * (i / COLUMNS);
    for (int n = count > 1 ? atoi(words[1]) : 1; n > 0; n--) run();
    printf("%.17g\n", theta[3] + theta_dot[5]);
}
