"""Writes the table of content models from the XSDs."""
import glob
import sys
from lxml import etree
XS='{http://www.w3.org/2001/XMLSchema}'
types={};elements={}
for f in glob.glob(sys.argv[1] + '/B2MML-*.xsd'):
    for c in etree.parse(f).getroot():
        if not isinstance(c.tag,str): continue
        n=c.tag.replace(XS,'')
        if n in('complexType','simpleType'): types.setdefault(c.get('name'),(n,c))
        if n=='element': elements[c.get('name')]=c.get('type')
roots=['EquipmentInformation','OperationsDefinition','OperationsDefinitionInformation','OperationsPerformance','OperationsSchedule','WorkflowSpecification','WorkflowSpecificationInformation']
order=[]
def bare(t): return t[:-4] if t.endswith('Type') and not t.startswith('xsd:') else t.replace('xsd:','xsd:')
def occ(e):
    lo=e.get('minOccurs','1');hi=e.get('maxOccurs','1')
    return {('1','1'):'',('0','1'):'?',('0','unbounded'):'*',('1','unbounded'):'+'}[(lo,hi)]
def walk(t):
    if t.startswith('xsd:') or t in order: return
    order.append(t)
    k,c=types[t]
    for e in c.iter(XS+'element'): walk(e.get('type'))
    for e in list(c.iter(XS+'extension'))+list(c.iter(XS+'restriction')): walk(e.get('base'))
for r in roots: walk(elements[r])
def part(e):
    return f"{e.get('name')}{occ(e)}:{bare(e.get('type'))}" + ('!' if e.get('nillable')=='true' else '')
out=[]
for r in roots: out.append(f"root {r} {bare(elements[r])}")
for t in sorted(order):
    k,c=types[t]
    seq=c.find(XS+'sequence')
    if seq is not None:
        parts=[]
        for e in seq:
            if not isinstance(e.tag,str): continue
            n=e.tag.replace(XS,'')
            if n=='element': parts.append(part(e))
            elif n=='choice':
                parts.append('('+'|'.join(part(x) for x in e)+')'+occ(e))
            elif n=='group': pass
            elif n=='annotation': pass
            else: raise SystemExit(n)
        assert not c.findall(XS+'attribute')
        head='sequence'
    else:
        base=[x for x in c.iter() if isinstance(x.tag,str) and x.tag in(XS+'extension',XS+'restriction')]
        assert len(base)==1
        b=base[0]
        parts=[bare(b.get('base'))]
        for x in b:
            if not isinstance(x.tag,str): continue
            n=x.tag.replace(XS,'')
            if n=='attribute':
                assert x.get('use','optional')=='optional'
                parts.append(f"@{x.get('name')}:{x.get('type')}")
            elif n=='enumeration': parts.append('='+x.get('value').replace(' ','_'))
            elif n=='pattern': parts.append('='+x.get('value'))
            elif n=='annotation': pass
            else: raise SystemExit(n)
        head='value'
    line=f"{head} {bare(t)}"
    for p in parts:
        if len(line)+1+len(p)>100: out.append(line); line='  '+p
        else: line+=' '+p
    out.append(line)
print('\n'.join(out))
