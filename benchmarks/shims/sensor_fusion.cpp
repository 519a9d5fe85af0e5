// aster94/SensorFusion: settings are 1 for Madgwick's filter, 0 for Mahony's, and 1 to begin with initQuat.
#include "Arduino.h"
#include "SensorFusion.cpp"
#include "loop.hpp"

extern "C" void sensor_fusion(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    SF filter;
    if (settings[1]) {
        const Reading &first = readings[0];
        filter.initQuat(first.accelerometer[0], first.accelerometer[1], first.accelerometer[2], first.magnetometer[0],
                        first.magnetometer[1], first.magnetometer[2]);
    }
    each(count, readings, attitudes, [&](const Reading &reading, double step) -> Attitude {
        give(
            reading,
            [&](auto... values) { settings[0] ? filter.MadgwickUpdate(values...) : filter.MahonyUpdate(values...); },
            step);
        const float *wxyz = filter.getQuat();
        return {wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
    });
}
