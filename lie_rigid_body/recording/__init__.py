"""Bags: MCAP files as rosbag2 writes and reads them.

- `records`: records, and where the messages among them stand, in a file, in a chunk, read or written;
- `summary`: what the records of a file declare and count, and the summary at its end;
- `mcap_writer`: messages laid out as arrays, many at once, in chunks, with their indexes and the summary;
- `bag_writer`: messages into an MCAP file, in batches or a whole run;
- `inflation`: the records of a chunk, within bounds;
- `mcap_reader`, `mcap_contents`: a file, read from its start to its end, as raw messages;
- `bag_files`: the files of a recording, and the bags of a folder;
- `recovery`, `recovered_folder`: what is whole of a file, or of a folder of them, that was cut off;
- `topic_messages`: raw messages of a topic as arrays;
- `topic_discovery`, `bag_reader`: the topics of each body of a bag, and each body as arrays;
- `poses`: trajectories of others, and the path through them;
- `segments`, `samples`: a bag as samples, segment by segment, and the readings of its sensors by their clocks.
"""
