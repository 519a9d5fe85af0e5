"""What tests of one kind of motion share with those of another lies in this folder, which is importable from below."""
