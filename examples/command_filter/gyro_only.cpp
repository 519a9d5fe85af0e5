// An attitude filter as a program: readings as CSV in, attitudes as CSV out. It integrates the gyro from the identity.
//
//   g++ -O2 -o gyro_only gyro_only.cpp
//   lie-rigid-body diagnose --command ./gyro_only
#include <cmath>
#include <complex>
#include <cstdio>

int main() {
  std::complex<double> a = 1, b = 0;  // the quaternion w + xi + yj + zk as a + bj: a = w + xi, b = y + zi
  long long t, before = -1;
  double x, y, z;
  for (char line[512]; std::fgets(line, sizeof line, stdin);) {
    if (std::sscanf(line, "%lld,%lf,%lf,%lf", &t, &x, &y, &z) != 4) continue;  // the header, or no gyro
    double h = before < 0 ? 0 : (t - before) / 2e9, n = std::hypot(x, y, z), s = n > 0 ? std::sin(n * h) / n : h;
    std::complex<double> c(std::cos(n * h), s * x), d(s * y, s * z), e = a * c - b * std::conj(d);
    b = a * d + b * std::conj(c), a = e, before = t;
    std::printf("%lld,%.17g,%.17g,%.17g,%.17g\n", t, a.imag(), b.real(), b.imag(), a.real());
  }
}
