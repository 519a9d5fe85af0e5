// CCNYRoboticsLab/imu_tools: settings of madgwick are the attitude to begin with, x y z w, as its node takes it from
// the first readings; of complementary 1 for the estimate of the gyro's bias, as its node has it, or 0.
#include "imu_complementary_filter/complementary_filter.h"
#include "imu_filter_madgwick/imu_filter.h"
#include "loop.hpp"

extern "C" void madgwick(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    ImuFilter filter;
    filter.setAlgorithmGain(0.1);
    filter.setDriftBiasGain(0.0);
    filter.setWorldFrame(WorldFrame::ENU);
    filter.setOrientation(settings[3], settings[0], settings[1], settings[2]);
    each(count, readings, attitudes, [&](const Reading &reading, double step) -> Attitude {
        give(reading, [&](auto... values) { filter.madgwickAHRSupdate(values...); }, step);
        Attitude told;
        filter.getOrientation(told.w, told.x, told.y, told.z);
        return told;
    });
}

extern "C" void complementary(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    imu_tools::ComplementaryFilter filter;
    filter.setDoBiasEstimation(settings[0] != 0.0);
    filter.setDoAdaptiveGain(true);
    each(count, readings, attitudes, [&](const Reading &reading, double step) -> Attitude {
        const double *w = reading.gyro, *a = reading.accelerometer, *m = reading.magnetometer;
        filter.update(a[0], a[1], a[2], w[0], w[1], w[2], m[0], m[1], m[2], step);
        Attitude told;
        filter.getOrientation(told.w, told.x, told.y, told.z);
        return told;
    });
}
