/* One Kalman filter step by hand, N states and P outputs fixed: the limit.

   What a careful programmer writes for one size: constant loops, symmetric halves,
   L d L', the short covariance Omega - K (Omega C')', no tests of anything.

   gcc -O3 -DN=3 -DP=2 -shared -fPIC -o step.so filter_step.c                        */

void filter(const double *A, const double *C, const double *Q, const double *R,
            double *x, double *S, const double *Y, double *X, long steps)
{
    double W[N][N], O[N][N], G[N][P], M[P][P], L[P][P], d[P], K[N][P], prior[N], r[P];
    for (long t = 0; t < steps; t++, Y += P, X += N) {
        for (int i = 0; i < N; i++) {
            double s = 0;
            for (int k = 0; k < N; k++) s += A[i * N + k] * x[k];
            prior[i] = s;
            for (int j = 0; j < N; j++) W[i][j] = 0;
            for (int k = 0; k < N; k++)
                for (int j = 0; j < N; j++) W[i][j] += A[i * N + k] * S[k * N + j];
        }
        for (int i = 0; i < N; i++)
            for (int j = i; j < N; j++) {
                double s = Q[i * N + j];
                for (int k = 0; k < N; k++) s += W[i][k] * A[j * N + k];
                O[i][j] = O[j][i] = s;
            }
        for (int i = 0; i < N; i++)
            for (int j = 0; j < P; j++) {
                double s = 0;
                for (int k = 0; k < N; k++) s += O[i][k] * C[j * N + k];
                G[i][j] = s;
            }
        for (int i = 0; i < P; i++) {
            r[i] = Y[i];
            for (int k = 0; k < N; k++) r[i] -= C[i * N + k] * prior[k];
            for (int j = i; j < P; j++) {
                double s = R[i * P + j];
                for (int k = 0; k < N; k++) s += C[i * N + k] * G[k][j];
                M[i][j] = M[j][i] = s;
            }
        }
        for (int j = 0; j < P; j++) {
            double s = M[j][j];
            for (int k = 0; k < j; k++) s -= L[j][k] * L[j][k] * d[k];
            d[j] = s;
            for (int i = j + 1; i < P; i++) {
                double q = M[i][j];
                for (int k = 0; k < j; k++) q -= L[i][k] * L[j][k] * d[k];
                L[i][j] = q / s;
            }
        }
        for (int i = 0; i < N; i++) {
            for (int j = 0; j < P; j++) {
                double s = G[i][j];
                for (int k = 0; k < j; k++) s -= L[j][k] * K[i][k];
                K[i][j] = s;
            }
            for (int j = 0; j < P; j++) K[i][j] /= d[j];
            for (int j = P - 1; j >= 0; j--)
                for (int k = j + 1; k < P; k++) K[i][j] -= L[k][j] * K[i][k];
        }
        for (int i = 0; i < N; i++) {
            double s = prior[i];
            for (int j = 0; j < P; j++) s += K[i][j] * r[j];
            X[i] = x[i] = s;
            for (int j = i; j < N; j++) {
                double c = O[i][j];
                for (int k = 0; k < P; k++) c -= K[i][k] * G[j][k];
                S[i * N + j] = S[j * N + i] = c;
            }
        }
    }
}
