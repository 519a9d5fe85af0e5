// arduino-libraries/MadgwickAHRS: settings are the rate of begin, Hz.
#include <math.h>
#include <stdint.h>
#define private public   // its quaternion has no getter
#define long int32_t     // as it is on the boards: invSqrt reads a float as a long
#include "MadgwickAHRS.cpp"
#undef long
#include "loop.hpp"

extern "C" void madgwick(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    Madgwick filter;
    filter.begin(settings[0]);
    each(count, readings, attitudes, [&](const Reading &reading, double) -> Attitude {
        give(reading, [&](auto... values) { filter.update(values...); });
        return {filter.q1, filter.q2, filter.q3, filter.q0};
    });
}
