// kriswiner/MPU9250, with the globals and gains of its sketch: settings are 1 for Madgwick's filter, 0 for Mahony's.
#include <math.h>
static float q[4], eInt[3], deltat;
static const float beta = sqrtf(3.0f / 4.0f) * 40.0f * float(M_PI) / 180.0f;
static const float Kp = 10.0f, Ki = 0.0f;
#include "quaternionFilters.ino"
#include "loop.hpp"

extern "C" void mpu9250(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    for (int i = 0; i < 4; ++i) q[i] = i == 0;
    for (float &sum : eInt) sum = 0.0f;
    each(count, readings, attitudes, [&](const Reading &reading, double step) -> Attitude {
        deltat = step;
        const double *w = reading.gyro, *a = reading.accelerometer, *m = reading.magnetometer;
        auto update = settings[0] ? MadgwickQuaternionUpdate : MahonyQuaternionUpdate;
        update(a[0], a[1], a[2], w[0], w[1], w[2], m[0], m[1], m[2]);
        return {q[1], q[2], q[3], q[0]};
    });
}
