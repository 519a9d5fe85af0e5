"""Bags: MCAP files as rosbag2 writes and reads them.

- `output_file`: a file that appears under its name when it is whole;
- `chunk`: message records laid out as arrays, many at once;
- `indexes`, `mcap_file`: everything else of an MCAP file, by the record types of the `mcap` library;
- `disk_queue`: the thread that compresses and writes;
- `bag_writer`: messages into an MCAP file, in batches or a whole run;
- `recovery`: what is whole of a file that was cut off;
- `inflation`: the records of a chunk, within bounds;
- `message_table`, `mcap_part`: records, and where the messages among them stand;
- `inventory`, `folder_metadata`: what a file or a folder says of itself, held against what it holds;
- `mcap_contents`, `mcap_reader`, `sqlite_reader`: a file as raw messages;
- `bag_files`, `bag_folders`: the files of a bag, and the bags of a folder;
- `topic_messages`: raw messages of a topic as arrays;
- `bodies`, `bag_reader`: the bodies of a bag, and each as arrays;
- `segments`, `samples`: a bag as samples, segment by segment, and the readings of its sensors by their clocks.
"""
