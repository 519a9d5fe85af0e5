"""Indexes of an MCAP file: what the summary says of a chunk or an attachment."""

from __future__ import annotations

from collections.abc import Mapping

from mcap.records import Attachment, AttachmentIndex, Chunk, ChunkIndex


def chunk_index(
    chunk: Chunk, begin: int, length: int, indexes: Mapping[int, int] | None = None, indexes_length: int = 0
) -> ChunkIndex:
    """Index of a chunk.

    Parameters
    ----------
    chunk : Chunk
    begin, length : int
        Byte where its record begins, and size of that.
    indexes : mapping of int to int, optional
        Bytes where the indexes of its messages begin, by channel.
    indexes_length : int, optional
        Size of these, bytes.
    """
    return ChunkIndex(
        message_start_time=chunk.message_start_time,
        message_end_time=chunk.message_end_time,
        chunk_start_offset=begin,
        chunk_length=length,
        message_index_offsets=dict(indexes or {}),
        message_index_length=indexes_length,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        uncompressed_size=chunk.uncompressed_size,
    )


def attachment_index(attachment: Attachment, begin: int, length: int) -> AttachmentIndex:
    """Index of an attachment whose record begins at a byte and has a size."""
    return AttachmentIndex(
        offset=begin,
        length=length,
        log_time=attachment.log_time,
        create_time=attachment.create_time,
        data_size=len(attachment.data),
        name=attachment.name,
        media_type=attachment.media_type,
    )
