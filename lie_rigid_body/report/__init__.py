"""A score as users see it: the options that ask for it, the table, the JSON, the picture and the page.

`request` holds what the command line asks for, of an estimate in a bag or on a topic, and answers with the score.
"""
