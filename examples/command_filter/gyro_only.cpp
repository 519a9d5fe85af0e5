// An attitude filter as a program: readings as CSV in, attitudes as CSV out. It integrates the gyro from the identity.
//
//   g++ -O2 -o gyro_only gyro_only.cpp
//   lie-rigid-body diagnose --command ./gyro_only
#include <cmath>
#include <cstdio>

int main() {
  double x = 0, y = 0, z = 0, w = 1, gx, gy, gz;
  long long t, before = -1;
  for (char line[512]; std::fgets(line, sizeof line, stdin);) {
    if (std::sscanf(line, "%lld,%lf,%lf,%lf", &t, &gx, &gy, &gz) != 4) continue;  // the header, or no gyro
    double dt = before < 0 ? 0 : (t - before) / 1e9, rate = std::sqrt(gx * gx + gy * gy + gz * gz);
    double s = rate > 0 ? std::sin(rate * dt / 2) / rate : 0, c = std::cos(rate * dt / 2), a = x, b = y, d = z, e = w;
    x = e * s * gx + a * c + b * s * gz - d * s * gy, y = e * s * gy - a * s * gz + b * c + d * s * gx;
    z = e * s * gz + a * s * gy - b * s * gx + d * c, w = e * c - s * (a * gx + b * gy + d * gz), before = t;
    std::printf("%lld,%.17g,%.17g,%.17g,%.17g\n", t, x, y, z, w);
  }
}
