"""Error against run time: a render whose error falls as it should, and one that is biased.

measure.py   the renders, and how often bands hold the slope
figure.py    the figure
page.py      the page: page.md with the numbers filled in
"""
