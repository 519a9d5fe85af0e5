"""Bags: MCAP files as rosbag2 writes and reads them.

- `output_file`: a file that appears under its name when it is whole;
- `bag_writer`: messages into an MCAP file;
- `mcap_reader`, `bag_reader`: an MCAP file as raw messages, and a bag as arrays.
"""
