"""Bags: message text and bytes, and MCAP files as rosbag2 writes and reads them."""
