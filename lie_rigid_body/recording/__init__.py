"""Bags: MCAP files as rosbag2 writes and reads them.

- `records`: records, and where the messages among them stand, in a file, in a chunk, read or written;
- `summary`: what a file says of itself at its end, made of its records, and held against what a file says;
- `mcap_file`: messages laid out as arrays, many at once, in chunks, with their indexes and the summary;
- `bag_writer`: messages into an MCAP file, in batches or a whole run;
- `inflation`: the records of a chunk, within bounds;
- `recovery`, `recovered_folder`: what is whole of a file, or of a folder of them, that was cut off;
- `damaged_file`: where the records of a damaged file stand;
- `mcap_contents`, `mcap_reader`: a file as raw messages;
- `bag_files`: the files of a bag, held against the metadata of their folder, and the bags of a folder;
- `topic_messages`: raw messages of a topic as arrays;
- `bodies`, `bag_reader`: the bodies of a bag, and each as arrays;
- `segments`, `samples`: a bag as samples, segment by segment, and the readings of its sensors by their clocks.
"""
