"""Names of functions in tables become links to the reference of Python."""

from docutils import nodes


def link_names(app, doctree, docname):
    """Links each `name` in a table that is a function of axode, unless it is a link already."""
    objects = app.env.get_domain("py").objects
    for table in doctree.findall(nodes.table):
        for literal in list(table.findall(nodes.literal)):
            entry = objects.get(f"axode.{literal.astext()}")
            if entry is None or entry.objtype != "function" or isinstance(literal.parent, nodes.reference):
                continue
            uri = app.builder.get_relative_uri(docname, entry.docname) + "#" + entry.node_id
            link = nodes.reference("", "", internal=True, refuri=uri)
            literal.replace_self(link)
            link += literal


def setup(app):
    app.connect("doctree-resolved", link_names)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
