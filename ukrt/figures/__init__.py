"""The paper's figures: cases enter, either solver runs them; pictures, the data behind them and a table of numbers that
can be compared with the paper's leave."""
