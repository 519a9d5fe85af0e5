"""The filter as a ROS 2 node: from imu/data_raw and imu/mag to imu/data, as the filters of imu_tools."""

import argparse
import sys

import numpy as np
import rclpy
from complementary_filter import ComplementaryFilter
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import Imu, MagneticField

EXECUTORS = {kind.__name__: kind for kind in (SingleThreadedExecutor, MultiThreadedExecutor)}


class ComplementaryFilterNode(Node):
    """Pairs readings of the same stamp, and publishes an attitude for each."""

    def __init__(self):
        super().__init__("complementary_filter")
        field = self.declare_parameter("world_field", [1.5e-6, 21.0e-6, -43.5e-6]).value
        gain = self.declare_parameter("gain", 1.0).value
        self.filter = ComplementaryFilter(field, gain)
        self.waiting = {Imu: {}, MagneticField: {}}
        self.publisher = self.create_publisher(Imu, "imu/data", 100)
        self.create_subscription(Imu, "imu/data_raw", self.hear, 100)
        self.create_subscription(MagneticField, "imu/mag", self.hear, 100)

    def hear(self, reading):
        """Take a reading of either sensor."""
        t_ns = reading.header.stamp.sec * 10**9 + reading.header.stamp.nanosec
        self.waiting[type(reading)][t_ns] = reading
        if all(t_ns in readings for readings in self.waiting.values()):
            self.publish(t_ns, *(readings[t_ns] for readings in self.waiting.values()))
            for kind, readings in self.waiting.items():  # what is older will find no partner
                self.waiting[kind] = {t: r for t, r in readings.items() if t > t_ns}

    def publish(self, t_ns, imu, mag):
        """Publish the reading of the IMU with the orientation that the filter has after it."""
        rate, force, field = imu.angular_velocity, imu.linear_acceleration, mag.magnetic_field
        vectors = (np.array([v.x, v.y, v.z]) for v in (rate, force, field))
        q = imu.orientation
        q.x, q.y, q.z, q.w = self.filter.update(t_ns, *vectors).tolist()
        imu.orientation_covariance = np.zeros(9)  # not known; -1 would say that there is no orientation
        self.publisher.publish(imu)


def main():
    """Run the node until Ctrl-C."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--executor", choices=EXECUTORS, default="SingleThreadedExecutor")
    given = parser.parse_args(remove_ros_args(sys.argv)[1:])
    rclpy.init()
    try:
        rclpy.spin(ComplementaryFilterNode(), EXECUTORS[given.executor]())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:  # of rclpy, after Ctrl-C amid a callback: there is nothing left to publish to
        if rclpy.ok():
            raise
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
