"""The command line: words in, words out; what is done stands in the packages that the commands call."""
