// An engine as a program: a case as one line of JSON in, a state after each step as CSV out. It takes steps of RK4.
//
//   g++ -O2 -o free_body free_body.cpp
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>

using State = std::array<double, 7>;  // attitude x y z w, body rate x y z
double M[9], J[9];                    // the inertia and its inverse

// The numbers behind a name, whatever brackets and commas stand between them.
void read(const std::string& json, const std::string& name, double* into, int count) {
  const char* at = json.c_str() + json.find("\"" + name + "\":") + name.size() + 3;
  for (char* end; count > 0; at = end) {
    while (*at == '[' || *at == ']' || *at == ',' || *at == ' ') ++at;
    *into++ = std::strtod(at, &end), --count;
  }
}

State derivative(const State& s) {
  double p[3], t[3], d[3];
  for (int i = 0; i < 3; ++i) p[i] = M[3 * i] * s[4] + M[3 * i + 1] * s[5] + M[3 * i + 2] * s[6];
  for (int i = 0; i < 3; ++i) t[i] = p[(i + 1) % 3] * s[4 + (i + 2) % 3] - p[(i + 2) % 3] * s[4 + (i + 1) % 3];
  for (int i = 0; i < 3; ++i) d[i] = J[3 * i] * t[0] + J[3 * i + 1] * t[1] + J[3 * i + 2] * t[2];
  double x = s[0], y = s[1], z = s[2], w = s[3], a = s[4] / 2, b = s[5] / 2, c = s[6] / 2;
  return {w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a, -x * a - y * b - z * c, d[0], d[1], d[2]};
}

State plus(State s, double h, const State& d) {
  for (int i = 0; i < 7; ++i) s[i] += h * d[i];
  return s;
}

int main() {
  std::string json;
  std::getline(std::cin, json);
  State s;
  double h, steps;
  read(json, "inertia", M, 9), read(json, "attitude_xyzw", &s[0], 4), read(json, "body_rate", &s[4], 3);
  read(json, "step", &h, 1), read(json, "steps", &steps, 1);
  for (int i = 0; i < 3; ++i)  // cofactors over the determinant
    for (int j = 0; j < 3; ++j) {
      int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
      J[3 * j + i] = M[3 * a + c] * M[3 * b + d] - M[3 * a + d] * M[3 * b + c];
    }
  double determinant = M[0] * J[0] + M[1] * J[3] + M[2] * J[6];
  for (double& entry : J) entry /= determinant;
  for (int n = 1; n <= steps; ++n) {
    State a = derivative(s), b = derivative(plus(s, h / 2, a)), c = derivative(plus(s, h / 2, b));
    State d = derivative(plus(s, h, c));
    s = plus(plus(plus(plus(s, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
    double norm = std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + s[3] * s[3]);
    for (int i = 0; i < 4; ++i) s[i] /= norm;
    std::printf("%.17g", n * h);
    for (double value : s) std::printf(",%.17g", value);
    std::printf("\n");
  }
}
