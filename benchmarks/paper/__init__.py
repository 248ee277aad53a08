"""The paper's results, one script each: `make paper`."""
